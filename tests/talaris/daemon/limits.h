#pragma once

// The limits of TALARIS' supervision outside a flight (tests/safety/limits.h).

#include "idl/talaris/codes.h"
#include "tests/safety/limits.h"
#include "world.h"

namespace lss::talaris {

using Limit = safety::Limit<World, Parameters>;

// Of one type only the last reading of each frame, as old as this at its end.
template <class Kind>
void only_as_old_as(World& w, TimeNs age) {
  w.distort = [&w, age](std::vector<TalarisSample>& samples) {
    TalarisSample last{};
    for (const TalarisSample& sample : samples) {
      if (std::holds_alternative<Kind>(sample.reading)) last = sample;
    }
    std::erase_if(samples,
                  [](const auto& sample) { return std::holds_alternative<Kind>(sample.reading); });
    if (!std::holds_alternative<Kind>(last.reading)) return;
    last.time_ns = w.time_ns_ - age;
    samples.push_back(last);
  };
}

inline std::vector<Limit> limits() {
  constexpr double kWarning_s = 3;
  const auto noticed = [](FaultId id, std::uint16_t subject) {
    return safety::fault_noticed<World>(id, subject);
  };
  const auto rest = [](World& w) { w.run(6); };  // longer than a module may take to boot
  const auto watched_supply = [=](World& w) {
    const auto i = static_cast<std::size_t>(find_tunable(tuning().infos, "gas.min_voltage_V"));
    if (w.vehicle_.tunables().value[i] == 0) {  // not looked at, as shipped
      ASSERT_EQ(w.set("gas.min_voltage_V", 21).phase, lss::Phase::completed);
    }
    rest(w);
  };
  const auto low_supply = noticed(faults::supply_low, kValveModule);

  return {
      {"no packet of the IMU",
       {"imu.silent_ms"},
       kWarning_s,
       [](World& w, const Parameters& p, bool above) {
         only_as_old_as<ImuPacket>(w, p.imu_silent_ns + (above ? 1 : 0));
       },
       noticed(faults::imu_silent, kImuModule),
       rest},
      {"no reading of the altimeter",
       {"altimeter.silent_ms"},
       kWarning_s,
       [](World& w, const Parameters& p, bool above) {
         only_as_old_as<Range>(w, p.altimeter_silent_ns + (above ? 1 : 0));
       },
       noticed(faults::altimeter_lost, kAltimeterModule),
       rest},
      {"lost packets of the IMU",
       {"imu.lost_per_s"},
       10,
       [](World& w, const Parameters& p, bool above) {
         const auto most = static_cast<std::uint64_t>(p.imu_lost_per_s / 5);  // in a frame
         w.alter = [=, since = w.time_ns_](World& x) {
           // Some time below, so that the mean has come to its value.
           x.imu_count += above && x.time_ns_ - since > 5 * kSecond ? most + 1 : most;
         };
       },
       noticed(faults::imu_lossy, kImuModule),
       rest},
      {"the supply",
       {"gas.min_voltage_V"},
       kWarning_s,
       [](World& w, const Parameters& p, bool above) {
         w.voltage_V = p.min_voltage_V + (above ? -0.01 : 0.01);
       },
       low_supply,
       watched_supply},
      {"the supply was low and is not any more",
       {},
       kWarning_s,
       [=](World& w, const Parameters& p, bool above) {
         w.voltage_V = p.min_voltage_V - 0.01;
         ASSERT_TRUE(w.run_until([&] { return low_supply(w); }, kWarning_s));
         w.voltage_V = p.min_voltage_V + (above ? 0.21 : 0.19);
       },
       [=](const World& w) { return w.heard(EventId::fault_cleared) != nullptr && !low_supply(w); },
       watched_supply},
      {"the bus thread stands still",
       {},
       2,
       [](World& w, const Parameters&, bool above) {
         w.alter = [=](World& x) {
           x.in_.bus.can.time_ns = x.time_ns_ - 200 * kMillisecond - (above ? 1 : 0);
         };
       },
       noticed(FaultId::bus_stuck, 0),
       [](World& w) { ASSERT_TRUE(w.start()); }},
      {"a node that is reset comes back",
       {"bus.reset_s"},
       130,
       [](World& w, const Parameters& p, bool above) {
         w.send(lss::CommandKind::reset, {double(kFanModule)});
         w.step();
         w.node(kFanNode).state = canopen::NodeState::booting;
         w.run(static_cast<double>(p.reset_ns) * 1e-9 + (above ? 2 : -2) * 0.2);
         if (above) return;
         w.node(kFanNode).state = canopen::NodeState::operational;
         ++w.node(kFanNode).boots;
       },
       noticed(FaultId::module_silent, kFanModule),
       rest},
  };
}

// How it flies, and limits of a flight, of which tests/talaris/gnc has those of guidance, contact,
// gas and contingencies; error solving.
inline std::set<std::string> no_limits(const std::set<std::string>& watched) {
  std::set<std::string> others;
  for (const TunableInfo& info : tuning().infos) {
    const std::string name = info.name;
    const std::string group = name.substr(0, name.find('.'));
    const bool of_flight =
        std::set<std::string>{"limits", "profile", "gains", "fans", "solve", "gas"}.contains(group);
    if (of_flight && !watched.contains(name)) others.insert(name);
  }
  return others;
}

}  // namespace lss::talaris
