#include "daemon/vehicles/ardito/config.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "daemon/config/reading.h"
#include "daemon/vehicles/ardito/tunables.h"
#include "idl/angles.h"

namespace lss::ardito {
namespace {

double millimetres(config::Section& s, std::string_view key, double fallback_m, double min_mm,
                   double max_mm) {
  return s.number(key, fallback_m * 1e3, min_mm, max_mm) * 1e-3;
}

template <std::size_t N>
void read_numbers(config::Section& s, std::string_view key, std::array<std::uint8_t, N>& nodes,
                  std::multiset<std::int64_t>& all) {
  const std::vector<std::int64_t> fallback(nodes.begin(), nodes.end());
  const auto read = s.integers(key, fallback, N, 1, 126);
  for (std::size_t i = 0; i < read.size() && i < N; ++i) {
    nodes[i] = static_cast<std::uint8_t>(read[i]);
    all.insert(read[i]);
  }
}

// The description of a kind of nodes, from its file; "": the shipped one.
void read_profile(config::Section& s, Kind kind, Profiles& profiles) {
  const auto k = static_cast<std::size_t>(kind);
  const std::string key = std::string(kKindNames[k]) + "_description";
  const std::string name = s.text(key, "");
  if (name.empty()) return;
  const std::filesystem::path path = std::filesystem::path(s.file()).parent_path() / name;
  std::ifstream file(path, std::ios::binary);
  if (!file) return s.error(key, fmt::format("\"{}\" cannot be read", path.string()));
  std::string text(canopen::kMostDescriptionBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  std::vector<std::string> errors;
  const Profile profile = make_profile(kind, text, errors);
  for (const std::string& error : errors) s.error(key, fmt::format("{}: {}", path.string(), error));
  if (errors.empty()) profiles[k] = profile;
}

void read_bus(config::Section s, Parameters& p) {
  for (std::size_t kind = 0; kind < kKinds; ++kind)
    read_profile(s, static_cast<Kind>(kind), p.bus.profile);
  std::multiset<std::int64_t> all;
  read_numbers(s, "wheel_nodes", p.bus.wheel_node, all);
  read_numbers(s, "steering_nodes", p.bus.steering_node, all);
  p.bus.io_node = static_cast<std::uint8_t>(s.integer("io_node", p.bus.io_node, 1, 126));
  p.bus.imu_node = static_cast<std::uint8_t>(s.integer("imu_node", p.bus.imu_node, 1, 126));
  p.bus.master_node =
      static_cast<std::uint8_t>(s.integer("master_node", p.bus.master_node, 1, 127));
  all.insert({p.bus.io_node, p.bus.imu_node, p.bus.master_node});
  for (const std::int64_t node : std::set(all.begin(), all.end())) {
    if (all.count(node) > 1)
      s.error("", fmt::format("node {} is there twice: give each its own number", node));
  }
  p.bus.sync_lead_ns = config::milliseconds(s, "sync_lead_ms", p.bus.sync_lead_ns, 1, 50);
  p.bus.stale_after_ns = config::milliseconds(s, "stale_ms", p.bus.stale_after_ns, 150, 5000);
  p.bus.heartbeat_timeout_ns =
      config::milliseconds(s, "heartbeat_timeout_ms", p.bus.heartbeat_timeout_ns, 150, 5000);
  p.bus.wheel_acceleration_rpm_s =
      s.number("wheel_acceleration_rpm_s", p.bus.wheel_acceleration_rpm_s, 100, 100'000);
  p.bus.steering_speed_rad_s =
      s.number("steering_speed_rad_s", p.bus.steering_speed_rad_s, 0.05, 5);
  p.bus.steering_acceleration_rad_s2 =
      s.number("steering_acceleration_rad_s2", p.bus.steering_acceleration_rad_s2, 0.05, 50);
  config::read_tunables(s, "bus", tuning().tunables, p);
}

void read_geometry(config::Section s, gnc::ardito::Geometry& g) {
  g.a_m = millimetres(s, "front_track_mm", g.a_m, 100, 5000);
  g.b_m = millimetres(s, "middle_track_mm", g.b_m, 100, 5000);
  g.c_m = millimetres(s, "rear_track_mm", g.c_m, 100, 5000);
  g.d_m = millimetres(s, "front_axle_mm", g.d_m, 50, 5000);
  g.e_m = millimetres(s, "rear_axle_mm", g.e_m, 50, 5000);
  g.f_m = millimetres(s, "middle_axle_mm", g.f_m, 5, 1000);
  g.wheel_radius_m = millimetres(s, "wheel_radius_mm", g.wheel_radius_m, 10, 1000);
  g.gear_ratio = s.number("gear_ratio", g.gear_ratio, 1, 1000);
}

template <std::size_t N>
void read_list(config::Section& s, std::string_view key, std::array<double, N>& values,
               double max) {
  const std::vector<double> read =
      s.numbers(key, std::vector<double>(values.begin(), values.end()), N, 0, max);
  std::copy(read.begin(), read.end(), values.begin());
}

void read_mobility(config::Section s, Parameters& all) {
  gnc::ardito::Parameters& p = all.mobility;
  config::read_tunables(s, "mobility", tuning().tunables, all);
  read_list(s, "no_load_rad_s", p.no_load_rad_s, 100);
  read_list(s, "no_load_current", p.no_load_current, 2);
  if (const char* wrong = gnc::ardito::check(p)) s.error("", wrong);
}

}  // namespace

Parameters read_parameters(config::Section& root) {
  Parameters p;
  read_bus(root.section("bus"), p);
  read_geometry(root.section("geometry"), p.mobility.geometry);
  p.bus.gear_ratio = p.mobility.geometry.gear_ratio;
  read_mobility(root.section("mobility"), p);
  if (const char* wrong = check_ramp(p)) root.error("bus", wrong);

  config::Section safety = root.section("safety");
  config::read_tunables(safety, "safety", tuning().tunables, p);

  config::Section solve = root.section("solve");
  for (std::size_t c = 0; c < kFaultClasses; ++c)
    config::read_strategies(solve, kFaultClassNames[c], kStrategyNames, p.solver.order[c]);
  config::read_tunables(solve, "solve", tuning().tunables, p);
  tuning().derive(p);
  return p;
}

}  // namespace lss::ardito
