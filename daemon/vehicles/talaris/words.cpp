#include "daemon/vehicles/talaris/words.h"

#include "gnc/talaris/calibration.h"
#include "idl/talaris/commands.h"

namespace lss::talaris {
namespace {

const auto kFindings = [] {
  using gnc::talaris::CalibrationFault;
  std::array<const char*, static_cast<std::size_t>(CalibrationFault::range_spread) + 1> names{};
  for (std::size_t i = 0; i < names.size(); ++i)
    names[i] = describe(static_cast<CalibrationFault>(i));
  return names;
}();

constexpr Presentation::Example kExamples[] = {
    {kind_of(lss::CommandKind::stop),
     "  lss-cli stop                     safely; then motors off\n"},
    {kind_of(lss::CommandKind::start),
     "  lss-cli start --hold             manual control, everything shut, until Ctrl-C\n"},
    {kind_of(CommandKind::valve),
     "  lss-cli valve 3 --time 2s        open, and shut again after 2 s\n"
     "  lss-cli valve 1,3,5,7 --time 500ms\n"
     "  lss-cli valve all --open off     shut\n"},
    {kind_of(CommandKind::pulse),
     "  lss-cli pulse 1,3 --on 80ms --delay 20ms --frames 10     in every frame of 200 ms\n"},
    {kind_of(CommandKind::enable),
     "  lss-cli enable 2,4,6,8           the lifting valves stay shut\n"},
    {kind_of(CommandKind::gnc),
     "  lss-cli gnc standby --hold\n"
     "  lss-cli run -e 'gnc calibrate; plan hop --height 2 --distance 30; gnc execute'\n"},
    {kind_of(CommandKind::plan),
     "  lss-cli plan hop --height 2 --distance 30\n"
     "  lss-cli plan turn --turn 90deg\n"},
    {kind_of(CommandKind::gains), "  lss-cli gains 2\n"},
    {kind_of(CommandKind::land),
     "  lss-cli land                     in flight: down, here and now\n"},
};

constexpr auto kPulse = kinds(CommandKind::pulse), kValve = kinds(CommandKind::valve),
               kGnc = kinds(CommandKind::gnc);
constexpr auto kManual = modes(Mode::manual);
constexpr auto kDutyCycle = modes(Mode::duty_cycle);
constexpr auto kByHand = modes(Mode::manual, Mode::duty_cycle);
constexpr auto kStandby = static_cast<double>(GncStep::standby),
               kCalibrate = static_cast<double>(GncStep::calibrate),
               kExecute = static_cast<double>(GncStep::execute);
constexpr Presentation::Step kSteps[] = {
    {kind_of(CommandKind::duty_cycle), kManual, kPulse},
    {kind_of(CommandKind::manual), kDutyCycle, kValve},
    {kind_of(CommandKind::gnc), kByHand, kGnc, kStandby, kCalibrate},
};
// The longest calibration that the configuration allows; one phase of a flight may last 120 s.
constexpr Presentation::Case kSlow[] = {{kind_of(CommandKind::gnc), 0, kCalibrate, 300},
                                        {kind_of(CommandKind::gnc), 0, kExecute, 240}};

constexpr Presentation::Words kWords[] = {{"phase", kPhaseNames}, {"program", kProgramNames}};
constexpr Presentation::Parts kParts[] = {
    {.field = "modules", .unheard = "last answered", .optional = 1u << (kLoadCellModule - 1)}};
constexpr const char* kPortAdvice = "check the port named in the config";
constexpr Presentation::Alarm kAlarms[] = {
    {"imu_port_open", true, "the line of the IMU is not open", kPortAdvice, kImuModule},
    {"altimeter_port_open", true, "the line of the altimeter is not open", kPortAdvice,
     kAltimeterModule},
    {"can_port_open", true, "the CAN bus is not open", kPortAdvice, kValveModule}};
constexpr const char* kDetails[] = {
    "valves.enabled", "valves.pulses",   "valves.fired_s",         "edges",
    "edge_worst_s",   "gyro_bias_rad_s", "accelerometer_bias_m_s2"};
constexpr auto kFirst = kinds(CommandKind::gnc, CommandKind::plan, CommandKind::land);
constexpr Presentation::Headline kHeadline[] = {{"program", "program"},
                                                {"phase", "phase"},
                                                {"airborne", "in the air"},
                                                {"calibrated", "calibrated"},
                                                {"position_m[0]", "height"},
                                                {"position_m[2]", "along"},
                                                {"velocity_m_s[0]", "climb"},
                                                {"velocity_m_s[2]", "speed along"},
                                                {"gas_left_thruster_s", "gas left"},
                                                {"remaining_s", "to go"}};

}  // namespace

const Vocabulary& vocabulary() {
  static const Vocabulary words{
      .modes = kModeNames,
      .modules = kSubjectNames,
      .strategies = kStrategyNames,
      .phases = kPhaseNames,
      .programs = kProgramNames,
      .findings = kFindings,
      .presentation = {
          .examples = kExamples,
          .begins = static_cast<std::uint8_t>(Mode::manual),
          .steps = kSteps,
          .slow = kSlow,
          .rest = kind_of(CommandKind::manual),
          .at_rest = "everything shut",
          .distance = "position_m[2]",
          .words = kWords,
          .parts = kParts,
          .alarms = kAlarms,
          .details = kDetails,
          .headline = kHeadline,
          .supply = "voltage_V",
          .first = kFirst,
          .without_client =
              "lands if it is in the air, then shuts its valves and switches its fans off"}};
  return words;
}

}  // namespace lss::talaris
