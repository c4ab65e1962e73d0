#include "daemon/vehicles/ardito/words.h"

#include "idl/ardito/commands.h"

namespace lss::ardito {
namespace {

constexpr Presentation::Example kExamples[] = {
    {kind_of(lss::CommandKind::stop),
     "  lss-cli stop                     safely; then motors off\n"},
    {kind_of(lss::CommandKind::start),
     "  lss-cli start --hold             beacon, then motors on, until Ctrl-C\n"
     "  lss-cli start --limit urc --hold up to 1 m/s, where the config allows it\n"},
    {kind_of(CommandKind::drive),
     "  lss-cli drive 0.3 --for 20s      straight ahead, then a safe stop\n"
     "  lss-cli drive 0.3 --heading 5deg --for 10s      an arc to the right\n"
     "  lss-cli drive -0.2               backward until Ctrl-C\n"
     "  lss-cli drive 0.3 --driver autonomous --detach  lss-cli heartbeat keeps it driving\n"},
    {kind_of(CommandKind::park),
     "  lss-cli park 0.3 --for 10s       turn right on the spot\n"
     "  lss-cli park -0.3                to the left until Ctrl-C\n"},
    {kind_of(CommandKind::halt),
     "  lss-cli halt --hold              stand, motors on, until Ctrl-C\n"},
};

constexpr Presentation::Words kWords[] = {{"nodes.link", kLinkNames}, {"nodes.drive", kDriveNames}};
constexpr Presentation::Parts kParts[] = {
    {.field = "wheels"},
    {.field = "steering", .first = kDriveWheels},
    {.field = "nodes", .unheard = "is {link}, last message", .lesser = 1u << (kImuNode - 1)}};
constexpr Presentation::Alarm kAlarms[] = {{.field = "port_open",
                                            .good = true,
                                            .text = "the CAN bus is not open",
                                            .advice = "check the port named in the config",
                                            .alone = true},
                                           {.field = "emergency_button",
                                            .good = false,
                                            .text = "the emergency-stop button is pressed",
                                            .advice = "release it"}};
constexpr const char* kDetails[] = {"nodes.address", "nodes.drive", "nodes.age_ms",
                                    "nodes.emergency", "nodes.emergencies"};
constexpr auto kFirst = kinds(CommandKind::drive, CommandKind::park, CommandKind::halt);
constexpr Presentation::Headline kHeadline[] = {
    {"measured_m_s", "speed"},
    {"speed_m_s", "commanded"},
    {"limit_m_s", "limit"},
    {"slip_share", "lost by slip", "mobility.slip_slows"},
    {"speed_share", "share driven"},
    {"sunk_m", "wheels sunk by", "mobility.sink_limit_m", "wheels"},
    {"distance_m", "driven"},
    {"x_m", "ahead"},
    {"y_m", "left"},
    {"yaw_rad", "turned"},
    {"imu_valid", "IMU trusted"},
    {"wheels.current_A", "current"}};

constexpr double kHold_m_s = 0.2;
constexpr auto kDrive = kind_of(CommandKind::drive), kPark = kind_of(CommandKind::park);
constexpr Presentation::Hold kHold[] = {
    {"forward", kDrive, {kHold_m_s, 0, kRequired}},
    {"backward", kDrive, {-kHold_m_s, 0, kRequired}},
    {"forward left", kDrive, {kHold_m_s, -kMaxHeading_rad, kRequired}},
    {"forward right", kDrive, {kHold_m_s, kMaxHeading_rad, kRequired}},
    {"left", kPark, {-kHold_m_s, kRequired, kRequired}},
    {"right", kPark, {kHold_m_s, kRequired, kRequired}}};

}  // namespace

const Vocabulary& vocabulary() {
  static const Vocabulary words{
      .modes = kModeNames,
      .modules = kNodeNames,
      .strategies = kStrategyNames,
      .presentation = {.examples = kExamples,
                       .rest = kind_of(CommandKind::halt),
                       .at_rest = "motors off",
                       .words = kWords,
                       .parts = kParts,
                       .alarms = kAlarms,
                       .details = kDetails,
                       .headline = kHeadline,
                       .supply = "wheels.voltage_V",
                       .hold = kHold,
                       .first = kFirst,
                       .without_client = "slows down, stands still and switches its motors off"}};
  return words;
}

}  // namespace lss::ardito
