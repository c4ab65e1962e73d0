// A vehicle from the dictionary of its daemon, beside the same one on the roster.

#include "tools/lss-cli/session/described_vehicle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zebro_fields.h>  // of the IDL

#include <algorithm>
#include <numbers>
#include <optional>

#include "tests/cli/zebro_dictionary.h"
#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

using test::zebro_dictionary;

class Described : public testing::Test {
 protected:
  // Under a name that has no overlay.
  static std::string strange() {
    json dictionary = json::parse(zebro_dictionary());
    dictionary["vehicle"] = "strider";
    return dictionary.dump();
  }
  DescribedVehicle described_{strange()};
  const Vehicle& vehicle_ = described_.vehicle();
  const Vehicle& built_ = *find_vehicle("zebro");
};

TEST_F(Described, CommandsAreThoseOfTheRoster) {
  EXPECT_EQ(command_names(vehicle_), command_names(built_));
  for (const CommandInfo* info : commands_of(built_)) {
    const CommandInfo& own = find_command(vehicle_, info->kind);
    EXPECT_EQ(to_json(own, vehicle_), to_json(*info, built_));
    EXPECT_EQ(own.ends_motion, info->ends_motion) << info->name;
    EXPECT_EQ(own.endless, info->endless) << info->name;
    EXPECT_THAT(describe(*info, built_), HasSubstr(describe(own, vehicle_)));
  }
  EXPECT_EQ(subject_name(vehicle_, 4), "RM");
  EXPECT_EQ(vehicle_.tunables.size(), built_.tunables.size());
}

TEST_F(Described, WordsMeanTheSame) {
  const auto read = [](const Vehicle& vehicle, const char* command,
                       const std::vector<std::string>& words) -> std::string {
    try {
      return describe(read_invocation(find_command(vehicle, command), vehicle, words, {}));
    } catch (const Failure& e) {
      const std::string name(vehicle.name);
      std::string text = e.what();
      if (text.starts_with(name)) text.erase(0, name.size());
      return text + " | " + e.advice();
    }
  };
  for (const auto& [command, words] :
       {std::pair{"walk", std::vector<std::string>{"high", "backward", "-30"}},
        std::pair{"walk", std::vector<std::string>{"hihg"}},
        std::pair{"walk", std::vector<std::string>{"200deg"}},
        std::pair{"leg", std::vector<std::string>{"RM", "1rad"}},
        std::pair{"leg", std::vector<std::string>{}},
        std::pair{"stop", std::vector<std::string>{"no"}},
        std::pair{"reset", std::vector<std::string>{"LF"}},
        std::pair{"panel", std::vector<std::string>{"deploy"}},
        std::pair{"wlak", std::vector<std::string>{}}})
    EXPECT_EQ(read(vehicle_, command, words), read(built_, command, words));
}

TEST_F(Described, MotionInIdleBeginsWithAStartAndTheStepsOfTheVehicle) {
  const auto steps = [&](lss_State state, const char* command) {
    lss_Status status{};
    status.state = state;
    std::vector<std::string> names;
    const Invocation wanted{&find_command(vehicle_, command), {}};
    for (const Invocation& step : vehicle_.prepare(status, wanted))
      names.emplace_back(step.info->name);
    return names;
  };
  EXPECT_THAT(steps(lss_STATE_IDLE, "walk"), ElementsAre("start", "stand"));
  EXPECT_THAT(steps(lss_STATE_IDLE, "start"), ElementsAre());
  EXPECT_THAT(steps(lss_STATE_IDLE, "panel"), ElementsAre());
  EXPECT_THAT(steps(lss_STATE_OPERATIONAL, "walk"), ElementsAre());
  EXPECT_THAT(steps(lss_STATE_FATAL_ERROR, "walk"), ElementsAre());
}

TEST_F(Described, ASampleHasAllFields) {
  // As the type of the dictionary lays it out, and as idlc does: the same up to the first array of
  // structs.
  std::vector<std::uint64_t> bytes(vehicle_.telemetry->m_size / sizeof(std::uint64_t) + 1);
  lss_ZebroTelemetry sample{};
  sample.time_ns = 5;
  sample.state = 1;
  ASSERT_GE(bytes.size() * sizeof bytes[0], offsetof(lss_ZebroTelemetry, modules));
  std::memcpy(bytes.data(), &sample, offsetof(lss_ZebroTelemetry, modules));
  const json own = status_json(vehicle_, lss_Status{}, bytes.data())["telemetry"];
  const json built = status_json(built_, lss_Status{}, &sample)["telemetry"];
  EXPECT_EQ(own["time_ns"], 5);
  EXPECT_EQ(own["state"], "Operational");
  for (const auto& [name, value] : built.items()) EXPECT_TRUE(own.contains(name)) << name;
  EXPECT_EQ(own.size(), built.size());
  EXPECT_EQ(own["modules"].size(), built["modules"].size());
  const std::string screen = vehicle_.screen(bytes.data(), {});
  EXPECT_THAT(screen, HasSubstr("distance"));
  EXPECT_THAT(screen, HasSubstr("current"));
  EXPECT_THAT(screen, testing::Not(HasSubstr("firmware_major")));
  EXPECT_THAT(vehicle_.details(bytes.data(), {}), HasSubstr("firmware_major"));
  EXPECT_EQ(vehicle_.distance_m(bytes.data()), 0);
  EXPECT_THAT(screen, HasSubstr("soil"));
  EXPECT_THAT(built_.screen(&sample, {}), HasSubstr("left side 0.00, right side 0.00"));
}

TEST_F(Described, CodesAreThoseOfTheDaemon) {
  json changed = json::parse(zebro_dictionary());
  changed["faults"].push_back({{"number", 999},
                               {"name", "rope_torn"},
                               {"severity", "fatal"},
                               {"text", "the rope is torn"},
                               {"advice", "tie it"}});
  const DescribedVehicle other(changed.dump());
  lss_Fault torn{};
  torn.id = 999;
  EXPECT_EQ(fault_text(other.vehicle(), torn), "the rope is torn");
  EXPECT_EQ(fault_text(vehicle_, torn), "fault 999");
}

TEST_F(Described, TheOverlayShowsOnlyTelemetryOfItsOwnIdl) {
  EXPECT_EQ(built_.telemetry, &lss_ZebroTelemetry_desc);
  EXPECT_EQ(vehicle_.overlay, nullptr);
  json newer = json::parse(zebro_dictionary());
  newer["telemetry"]["idl"] = newer["telemetry"]["idl"].get<std::string>() + "// and more\n";
  const DescribedVehicle other(newer.dump());
  EXPECT_NE(other.vehicle().overlay, nullptr);
  EXPECT_NE(other.vehicle().telemetry, &lss_ZebroTelemetry_desc);
}

TEST_F(Described, ProblemsAreTheAlarmsAndThePartsThatAreSilent) {
  lss_ZebroTelemetry sample{};
  lss_Status status{};
  const auto texts = [&] {
    std::vector<std::string> all;
    for (const Problem& problem : built_.problems(status, &sample)) all.push_back(problem.text);
    return all;
  };
  for (std::size_t i = 0; i < std::size(sample.modules); ++i) {
    sample.modules[i].id = static_cast<std::uint8_t>(i + 1);
    sample.modules[i].online = true;
  }
  EXPECT_THAT(texts(), ElementsAre("the bus port is not open"));
  sample.port_open = true;
  EXPECT_THAT(texts(), ElementsAre());
  sample.modules[3].online = sample.modules[0].online = false;
  sample.modules[3].age_ms = 3000;
  sample.modules[0].age_ms = kNeverHeard_ms;
  EXPECT_THAT(texts(),
              ElementsAre("LF has never answered", "RM does not answer, last reply 3.0 s ago"));
  status.faults[0].id = static_cast<std::uint16_t>(FaultId::module_silent);
  status.faults[0].subject = 4;
  EXPECT_THAT(texts(), ElementsAre("LF has never answered"));
}

TEST(TelemetryScreen, HasARowForEachElementUnitsOfPeopleAndWords) {
  static constexpr const char* kNames[] = {"left", "right"};
  Shown shown;
  shown.subjects = kNames;
  shown.parts["drives"] = {};
  shown.words["drives.link"] = {{"off", "on"}};
  shown.details = {"drives.address"};
  const nlohmann::ordered_json telemetry = with_words(
      nlohmann::ordered_json::parse(R"({"time_ns": 5, "yaw_rad": 1.5707963267948966, "drives": [
          {"id": 1, "address": 16, "link": 1, "angle_rad": 0.0, "age_ms": 5},
          {"id": 2, "address": 17, "link": 0, "angle_rad": -3.141592653589793, "age_ms": 7}]})"),
      shown);
  EXPECT_EQ(telemetry["drives"][1]["name"], "right");
  EXPECT_EQ(telemetry_screen(telemetry, shown, {}),
            "yaw                                  90 deg\n\n"
            "drives link angle age\n"
            "              deg  ms\n"
            "left     on     0   5\n"
            "right   off  -180   7\n\n");
  EXPECT_EQ(telemetry_details(telemetry, shown, {}),
            "drives address\n"
            "left        16\n"
            "right       17\n\n");
}

// "modules.current_A", "position_m[2]", "yaw_rad"
bool is_field(const json& fields, std::string path) {
  const std::size_t dot = path.find('.');
  std::string name = path.substr(0, dot);
  std::optional<std::size_t> index;
  if (const std::size_t open = name.find('['); open != std::string::npos) {
    index = std::stoul(name.substr(open + 1));
    name.resize(open);
  }
  for (const json& field : fields) {
    if (field["name"] != name) continue;
    if (index.has_value() && *index >= field.value("count", std::size_t{0})) return false;
    return dot == std::string::npos ||
           (field.contains("fields") && is_field(field["fields"], path.substr(dot + 1)));
  }
  return false;
}

TEST(Dictionary, NamesOnlyWhatIsThere) {
  for (const std::string& text : built_dictionaries()) {
    const json all = json::parse(text);
    const json &fields = all["telemetry"]["fields"], &presentation = all["presentation"];
    EXPECT_FALSE(presentation["headline"].empty()) << all["vehicle"];
    for (const char* list : {"headline", "words", "parts", "alarms"}) {
      for (const json& entry : presentation[list])
        EXPECT_TRUE(is_field(fields, entry["field"])) << all["vehicle"] << " " << list << entry;
    }
    for (const json& line : presentation["headline"]) {
      const auto named = [](const json& list, const char* member, const json& name) {
        return std::ranges::any_of(list, [&](const json& one) { return one[member] == name; });
      };
      EXPECT_TRUE(!line.contains("limit") || named(all["parameters"], "name", line["limit"]))
          << all["vehicle"] << line;
      EXPECT_TRUE(!line.contains("parts") || named(presentation["parts"], "field", line["parts"]))
          << all["vehicle"] << line;
    }
    for (const json& detail : presentation["details"])
      EXPECT_TRUE(is_field(fields, detail)) << all["vehicle"] << " " << detail;
    EXPECT_TRUE(is_field(fields, presentation["distance"])) << all["vehicle"];
    for (const json& kind : presentation["first"]) {
      const auto& commands = all["commands"];
      EXPECT_TRUE(std::ranges::any_of(commands, [&](const json& c) { return c["kind"] == kind; }))
          << all["vehicle"] << " " << kind;
    }
  }
}

TEST(Dictionary, HasTheUnitsOfPeople) {
  const json& fields = *find_vehicle("zebro")->fields;
  const auto yaw =
      std::ranges::find_if(fields, [](const json& f) { return f["name"] == "yaw_rad"; });
  ASSERT_NE(yaw, fields.end());
  EXPECT_EQ((*yaw)["label"], "yaw");
  EXPECT_EQ((*yaw)["shown"]["unit"], "deg");
  EXPECT_DOUBLE_EQ((*yaw)["shown"]["factor"].get<double>(), 180 / std::numbers::pi);
}

TEST(Dictionary, ThatCannotBeReadIsRefused) {
  const auto refusal = [](const std::string& text) -> std::string {
    try {
      DescribedVehicle vehicle(text);
    } catch (const Failure& e) {
      return e.what();
    }
    return "was taken";
  };
  const auto with = [](const char* where, const json& value) {
    json changed = json::parse(zebro_dictionary());
    changed[json::json_pointer(where)] = value;
    return changed.dump();
  };
  EXPECT_EQ(refusal(zebro_dictionary()), "was taken");
  EXPECT_THAT(refusal(""), HasSubstr("cannot be read"));
  EXPECT_THAT(refusal("[]"), HasSubstr("cannot be read"));
  EXPECT_THAT(refusal("{}"), HasSubstr("commands"));
  const json common = json::parse(zebro_dictionary())["commands"];
  std::size_t walk = 0;
  while (common[walk]["name"] != "walk") ++walk;
  const std::string at = "/commands/" + std::to_string(walk);
  EXPECT_THAT(refusal(with((at + "/name").c_str(), "--help")), HasSubstr("no name"));
  EXPECT_THAT(refusal(with((at + "/name").c_str(), 7)), HasSubstr("cannot be read"));
  EXPECT_THAT(refusal(with((at + "/parameters/0/max").c_str(), 5)), HasSubstr("2 choices"));
  EXPECT_THAT(refusal(with((at + "/parameters").c_str(), json(9, common[walk]["parameters"][1]))),
              HasSubstr("9 parameters"));
  EXPECT_THAT(refusal(with("/telemetry/type", "lss::Nothing")), HasSubstr("lss::Nothing"));
  EXPECT_THAT(refusal(with("/presentation/rest", 4711)), HasSubstr("4711"));
  EXPECT_THAT(refusal(with("/presentation/steps/0/step", 4711)), HasSubstr("4711"));
  EXPECT_THAT(refusal(with("/presentation/steps/0/modes", "all")), HasSubstr("cannot be read"));
  EXPECT_THAT(refusal(with("/presentation/ends/0/index", 8)), HasSubstr("parameter 8"));
  EXPECT_THAT(refusal(with("/presentation/words/0/words", {1, 2})), HasSubstr("cannot be read"));
  EXPECT_THAT(refusal(with("/presentation/parts/0/first", "x")), HasSubstr("cannot be read"));
  EXPECT_THAT(refusal(with("/presentation/alarms/0", 7)), HasSubstr("cannot be read"));
  EXPECT_THAT(refusal(with("/telemetry/idl", "struct {")), HasSubstr("IDL"));
  EXPECT_THAT(
      refusal(with("/telemetry/idl", "module lss { struct ZebroTelemetry { double x; }; };")),
      HasSubstr("vehicle_id"));
}

}  // namespace
}  // namespace lss::cli
