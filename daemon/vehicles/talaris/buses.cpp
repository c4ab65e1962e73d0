#include "daemon/vehicles/talaris/buses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "daemon/runtime/clock.h"

namespace lss::talaris {
namespace {

const config::Port* find_port(const config::Config& config, std::string_view name) {
  const auto port = std::ranges::find(config.ports, name, &config::Port::name);
  return port != config.ports.end() ? &*port : nullptr;
}

// Ports of the altimeters at the corners.
constexpr std::array<const char*, kCornerAltimeters> kCornerPorts = {"corner_1", "corner_2",
                                                                     "corner_3", "corner_4"};

SerialSettings settings(const config::Config& config, const char* name, const SensorLine& line) {
  const config::Port* port = find_port(config, name);
  if (port == nullptr) return {};
  const SerialFormat format = line.format();
  return {.path = port->path,
          .baud = format.baud,
          .half_duplex = format.half_duplex || port->half_duplex,
          .parity = format.parity,
          .stop_bits = format.stop_bits};
}

std::string can_path(const config::Config& config) {
  const config::Port* port = find_port(config, "can");
  return port != nullptr ? port->path : "";
}

// What is wrong with the ports: a sentence, or "".
std::string wrong_ports(const config::Config& config, const BusesParameters& p) {
  std::vector<std::string_view> used{"imu", "altimeter", "can"};
  if (p.has_camera) used.push_back("camera");
  if (p.has_standby) used.push_back("standby_imu");
  if (p.has_corners) used.insert(used.end(), kCornerPorts.begin(), kCornerPorts.end());
  for (const std::string_view name : used) {
    if (find_port(config, name) == nullptr)
      return fmt::format("there is no [[port]] with name = \"{}\": add one", name);
  }
  for (const config::Port& port : config.ports) {
    if (std::ranges::find(used, port.name) != used.end()) continue;
    const bool corner = std::ranges::find(kCornerPorts, port.name) != kCornerPorts.end();
    const bool known = corner || port.name == "camera" || port.name == "standby_imu";
    return known ? fmt::format(
                       "nothing reads the port \"{}\": set present = true in "
                       "[talaris.{}], or remove its [[port]]",
                       port.name, corner ? "corner_altimeters" : port.name)
                 : fmt::format(
                       "nothing reads the port \"{}\": the names are imu, altimeter, "
                       "can, camera, standby_imu and corner_1 to corner_4",
                       port.name);
  }
  if (!p.has_corners) return "";
  for (const char* name : kCornerPorts) {
    const auto baud = find_port(config, name)->baud, middle = find_port(config, "altimeter")->baud;
    if (baud != middle)
      return fmt::format(
          "the port \"{}\" has {} baud and \"altimeter\" {}: they are of one kind, give both one "
          "baud",
          name, baud, middle);
  }
  return "";
}

// Of the configured IMU.
int packets(const BusesParameters& p) {
  return p.imu == ImuKind::landmark30 ? p.landmark.packets_per_frame : p.crossbow.packets_per_frame;
}
TimeNs packet_period(const BusesParameters& p) {
  return p.imu == ImuKind::landmark30 ? p.landmark.period_ns : p.crossbow.period_ns;
}

LineBus corner_bus(Ar1000& line, const config::Config& config, std::size_t corner) {
  return LineBus(LineEnds{.line = &line}, settings(config, kCornerPorts[corner], line));
}

LineReport report_of(const LineBus::Report& bus) noexcept {
  return {
      .status = bus.counters, .time_ns = bus.time_ns, .open = bus.open, .was_open = bus.was_open};
}

}  // namespace

BusesParameters complete(BusesParameters p, const config::Config& config) {
  if (const config::Port* imu = find_port(config, "imu"))
    p.landmark.baud = p.crossbow.baud = static_cast<int>(imu->baud);
  if (const config::Port* altimeter = find_port(config, "altimeter"))
    p.altimeter.baud = static_cast<int>(altimeter->baud);
  if (const config::Port* camera = find_port(config, "camera"))
    p.camera.baud = static_cast<int>(camera->baud);
  if (const config::Port* standby = find_port(config, "standby_imu"))
    p.standby.baud = static_cast<int>(standby->baud);
  p.valves.frame_ns = config.period_ns;
  p.valves.node = p.can.node[kValveNode];
  p.valves.fan_node = p.can.node[kFanNode];
  return p;
}

Buses::Buses(const config::Config& config, const BusesParameters& parameters)
    : wrong_ports_(wrong_ports(config, parameters)),
      parameters_(complete(parameters, config)),
      period_ns_(config.period_ns),
      offset_ns_(config.offset_ns),
      frames_({.packets = static_cast<std::uint32_t>(packets(parameters_)),
               .period_ns = config.period_ns,
               .grace_ns = parameters_.grace_ns}),
      landmark_(parameters_.landmark),
      crossbow_(parameters_.crossbow),
      ar1000_(parameters_.altimeter),
      flow_camera_(parameters_.camera),
      standby_imu_(parameters_.standby),
      imu_(LineEnds{.line = &imu_line(), .frames = &frames_}, settings(config, "imu", imu_line())),
      altimeter_(LineEnds{.line = &ar1000_}, settings(config, "altimeter", ar1000_)),
      camera_(LineEnds{.line = &flow_camera_}, settings(config, "camera", flow_camera_)),
      standby_(LineEnds{.line = &standby_imu_}, settings(config, "standby_imu", standby_imu_)),
      corner_{{Ar1000(parameters_.altimeter), Ar1000(parameters_.altimeter),
               Ar1000(parameters_.altimeter), Ar1000(parameters_.altimeter)}},
      corners_{{corner_bus(corner_[0], config, 0), corner_bus(corner_[1], config, 1),
                corner_bus(corner_[2], config, 2), corner_bus(corner_[3], config, 3)}},
      extra_{{{&camera_, "bus/camera", parameters_.has_camera},
              {&standby_, "bus/standby_imu", parameters_.has_standby},
              {&corners_[0], "bus/corner_1", parameters_.has_corners},
              {&corners_[1], "bus/corner_2", parameters_.has_corners},
              {&corners_[2], "bus/corner_3", parameters_.has_corners},
              {&corners_[3], "bus/corner_4", parameters_.has_corners}}},
      can_(parameters_.can, can_path(config), canopen::filters()),
      actuation_(parameters_.valves, can_) {
  can_.line().attach(actuation_.sender());
}

SensorLine& Buses::imu_line() noexcept {
  if (parameters_.imu == ImuKind::crossbow) return crossbow_;
  return landmark_;
}

std::string Buses::wrong_configuration() const {
  if (!wrong_ports_.empty()) return wrong_ports_;
  if (packets(parameters_) * packet_period(parameters_) != period_ns_)
    return fmt::format(
        "[frame] period_ms is {}: {} packets of this IMU make frames of {} ms",
        static_cast<double>(period_ns_) * 1e-6, packets(parameters_),
        static_cast<double>(packets(parameters_) * packet_period(parameters_)) * 1e-6);
  // A late frame is repeated once; the next one comes two periods after the last.
  const TimeNs fresh_ns = 2 * period_ns_ + offset_ns_ + std::min(parameters_.grace_ns, period_ns_);
  if (std::min(parameters_.can.stale_after_ns, parameters_.valves.stale_after_ns) < fresh_ns)
    return fmt::format(
        "[talaris.bus] stale_ms must be at least {:.0f}: two frames, the offset and the grace, so "
        "that one late frame shuts nothing",
        std::ceil(static_cast<double>(fresh_ns) * 1e-6));
  return "";
}

tl::expected<void, std::string> Buses::probe() {
  for (LineBus* line : {&imu_, &altimeter_}) {
    if (auto ok = line->probe(); !ok) return ok;
  }
  for (const Extra& each : extra_) {
    if (!each.present) continue;
    if (auto ok = each.line->probe(); !ok) return ok;
  }
  return can_.probe();
}

std::vector<std::pair<std::string, std::function<void()>>> Buses::bodies() {
  std::vector<std::pair<std::string, std::function<void()>>> all = {
      {"bus/imu", [this] { imu_.run(); }},
      {"bus/altimeter", [this] { altimeter_.run(); }},
      {"bus/can", [this] { can_.run(); }}};
  for (const Extra& each : extra_) {
    if (each.present) all.emplace_back(each.thread, [line = each.line] { line->run(); });
  }
  return all;
}

std::vector<Progress> Buses::progress() const {
  std::vector<Progress> all = {{"bus/imu", imu_.turns(), false},
                               {"bus/altimeter", altimeter_.turns(), false},
                               {"bus/can", can_.turns()}};
  for (const Extra& each : extra_) {
    if (each.present) all.push_back({each.thread, each.line->turns(), false});
  }
  return all;
}

void Buses::stop() noexcept {
  imu_.stop();
  altimeter_.stop();
  for (const Extra& each : extra_) each.line->stop();
  can_.stop();
}

std::size_t Buses::collect(TimeNs boundary_ns, std::span<TalarisSample> samples,
                           BusReport& report) noexcept {
  std::size_t count = 0;
  const auto take = [&](auto& bus) {
    while (count < samples.size() && bus.pop(samples[count], boundary_ns)) ++count;
  };
  take(imu_);
  take(altimeter_);
  while (count < samples.size() && standby_.pop(samples[count], boundary_ns)) {
    if (of_standby(samples[count])) ++count;
  }
  take(can_);
  take(camera_);  // behind the others: what it says too much displaces nothing
  std::uint64_t overflows = 0;
  for (std::size_t i = 0; parameters_.has_corners && i < kCornerAltimeters; ++i) {
    const std::size_t before = count;
    take(corners_[i]);
    for (TalarisSample& sample : samples.subspan(before, count - before))
      of_corner(sample, static_cast<std::uint8_t>(i + 1));
    overflows += corners_[i].report().counters.counters.overflows;
  }
  report = {.imu = report_of(imu_.report()),
            .altimeter = report_of(altimeter_.report()),
            .camera = report_of(camera_.report()),
            .standby = report_of(standby_.report()),
            .corner_overflows = overflows,
            .can = can_.report(),
            .edges = actuation_.report()};
  return count;
}

bool Buses::take_memory_lost() noexcept {
  bool lost = can_.take_memory_lost();
  lost = actuation_.take_memory_lost() || lost;
  lost = frames_.take_memory_lost() || lost;
  for (LineBus* line : {&imu_, &altimeter_}) lost = line->take_memory_lost() || lost;
  for (const Extra& each : extra_) lost = each.line->take_memory_lost() || lost;
  return lost;
}

void Buses::release(const TalarisOrders& orders, const Boundary& boundary) noexcept {
  actuation_.release(orders, boundary.time_ns + offset_ns_, now_ns());
}

void Buses::all_stop() noexcept {
  actuation_.all_stop(now_ns());
  frames_.wake_actuate();
}

}  // namespace lss::talaris
