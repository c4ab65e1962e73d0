#include "daemon/vehicles/zebro/words.h"

#include "idl/zebro/commands.h"

namespace lss::zebro {
namespace {

constexpr Presentation::Example kExamples[] = {
    {kind_of(lss::CommandKind::start),
     "  lss-cli start --hold             motors on, until Ctrl-C\n"
     "  lss-cli start stand --hold       and stand up\n"},
    {kind_of(lss::CommandKind::stop),
     "  lss-cli stop                     ends the motion, lies down, motors off\n"
     "  lss-cli stop --lay-down no       stays as it stands, motors off\n"},
    {kind_of(lss::CommandKind::reset), "  lss-cli reset RM                 one module\n"},
    {kind_of(CommandKind::stand),
     "  lss-cli stand --hold             from wherever it is; stays standing until Ctrl-C\n"
     "  lss-cli stand --dry-run          would it be accepted?\n"},
    {kind_of(CommandKind::lay_down), "  lss-cli lay-down\n"},
    {kind_of(CommandKind::stow), "  lss-cli stow\n"},
    {kind_of(CommandKind::walk),
     "  lss-cli walk forward --speed high --for 20s\n"
     "  lss-cli walk backward low        until Ctrl-C\n"
     "  lss-cli walk --heading 90 --for 1min    turns right on the spot\n"
     "  lss-cli walk --detach            lss-cli heartbeat keeps it walking\n"},
    {kind_of(CommandKind::panel), "  lss-cli panel deploy\n  lss-cli panel retract\n"},
    {kind_of(CommandKind::leg),
     "  lss-cli leg RM 90 --hold         one leg to 90 deg, then hold\n"
     "  lss-cli leg 4 1.57rad backward --duration 5s\n"},
};

// A movement that cannot be interrupted in favour of the wanted one ends first; it walks from
// standing.
constexpr auto kNotLayDown =
    kinds(CommandKind::stand, CommandKind::stow, CommandKind::walk, CommandKind::leg);
constexpr auto kNotStow =
    kinds(CommandKind::stand, CommandKind::lay_down, CommandKind::walk, CommandKind::leg);
constexpr auto kNotUp = kinds(CommandKind::lay_down, CommandKind::stow, CommandKind::leg);
constexpr auto kLeg = kinds(CommandKind::leg);
constexpr auto kWalk = kinds(CommandKind::walk);
constexpr auto kLyingDown = modes(Mode::lying_down);
constexpr auto kStowing = modes(Mode::stowing);
constexpr auto kRising = modes(Mode::standing_up);
constexpr auto kStepping = modes(Mode::walking, Mode::finishing_step);
constexpr auto kNotUpright =
    modes(Mode::holding, Mode::standing_up, Mode::finishing_step, Mode::lying_down, Mode::lying,
          Mode::stowing, Mode::stowed, Mode::bridge);
constexpr Presentation::Step kSteps[] = {
    {kind_of(CommandKind::lay_down), kLyingDown, kNotLayDown},
    {kind_of(CommandKind::stow), kStowing, kNotStow},
    {kind_of(CommandKind::stand), kRising, kNotUp},
    {kind_of(CommandKind::stand), kStepping, kLeg},
    {kind_of(CommandKind::stand), kNotUpright, kWalk},
};
constexpr Presentation::Case kEnds[] = {
    {kind_of(CommandKind::walk), 2, static_cast<double>(WalkSpeed::zero)}};

constexpr const char* kResetCauses[] = {"power-on", "watchdog", "brown-out", "command", "software"};
constexpr Presentation::Words kWords[] = {{"speed", kSpeeds},
                                          {"modules.reset_cause", kResetCauses, true}};
constexpr const char* kDetails[] = {
    "modules.address",  "modules.firmware_major", "modules.firmware_minor", "modules.reset_cause",
    "modules.uptime_s", "modules.age_ms",         "modules.replies",        "modules.resends",
    "modules.flags",    "modules.time_left_s"};
constexpr Presentation::Parts kParts[] = {
    {.field = "modules", .unheard = "does not answer, last reply"}};
constexpr Presentation::Alarm kAlarms[] = {{.field = "port_open",
                                            .good = true,
                                            .text = "the bus port is not open",
                                            .advice = "check the port named in the config",
                                            .alone = true}};
constexpr auto kFirst = kinds(CommandKind::walk, CommandKind::stand, CommandKind::lay_down);
constexpr const char* kSoil = "ground.soil_share";
constexpr Presentation::Headline kHeadline[] = {{"speed_m_s", "speed"},
                                                {"distance_m", "walked"},
                                                {"yaw_rad", "turned"},
                                                {"steps", "gait cycles"},
                                                {"rows", "by rowing"},
                                                {"soil_share[0]", "left side in soil", kSoil},
                                                {"soil_share[1]", "right side in soil", kSoil},
                                                {"modules.current_A", "current"}};
// Walk's direction (1: forward), heading and speed.
constexpr Presentation::Hold hold_walk(const char* way, double forward, double heading_rad) {
  return {way, kind_of(CommandKind::walk), {forward, heading_rad, kRequired}};
}
constexpr Presentation::Hold kHold[] = {hold_walk("forward", 1, 0),
                                        hold_walk("backward", 0, 0),
                                        hold_walk("forward left", 1, -30 * kDegree),
                                        hold_walk("forward right", 1, 30 * kDegree),
                                        hold_walk("left", 1, -90 * kDegree),
                                        hold_walk("right", 1, 90 * kDegree)};

}  // namespace

const Vocabulary& vocabulary() {
  static const Vocabulary words{
      .modes = kModeNames,
      .modules = kModuleNames,
      .strategies = kStrategyNames,
      .presentation = {
          .examples = kExamples,
          .begins = static_cast<std::uint8_t>(Mode::holding),
          .steps = kSteps,
          .ends = kEnds,
          .rest = kind_of(CommandKind::stand),
          .at_rest = "motors off",
          .words = kWords,
          .parts = kParts,
          .alarms = kAlarms,
          .details = kDetails,
          .headline = kHeadline,
          .supply = "modules.supply_V",
          .hold = kHold,
          .first = kFirst,
          .without_client = "finishes its step, lies down and switches its motors off"}};
  return words;
}

}  // namespace lss::zebro
