#include "drivers/ardito/profile.h"

#include <ardito_devices.h>  // the text of config/devices, by the build

#include <algorithm>
#include <cstdio>
#include <span>

namespace lss::ardito {
namespace {

enum class Use : std::uint8_t { sent, received, written };  // by PDO to and from the node; by SDO

struct Signal {
  const char* name;
  Use use;
  std::uint8_t pdo = 0;    // its number
  std::uint8_t bytes = 0;  // 0: 1, 2 or 4
  bool optional = false;
};

constexpr Signal kWheel[] = {{"Controlword", Use::sent, 1, 2},
                             {"TargetVelocity", Use::sent, 1, 4},
                             {"Statusword", Use::received, 1, 2},
                             {"Velocity", Use::received, 1},
                             {"Current", Use::received, 1},
                             {"HallVelocity", Use::received, 2},
                             {"WheelVelocity", Use::received, 2},
                             {"Temperature", Use::received, 3},
                             {"LinkVoltage", Use::received, 3, 0, true},
                             {"Acceleration", Use::written},
                             {"Deceleration", Use::written},
                             {"QuickStopDeceleration", Use::written}};
constexpr Signal kSteering[] = {
    {"Controlword", Use::sent, 1, 2},    {"TargetPosition", Use::sent, 1, 4},
    {"Statusword", Use::received, 1, 2}, {"Position", Use::received, 1},
    {"Current", Use::received, 1},       {"WheelPosition", Use::received, 2},
    {"ProfileVelocity", Use::written},   {"Acceleration", Use::written},
    {"Deceleration", Use::written},      {"QuickStopDeceleration", Use::written}};
constexpr Signal kIoSignals[] = {{"Outputs", Use::sent, 1, 1},
                                 {"Inputs", Use::received, 1, 1},
                                 {"Beta", Use::received, 2},
                                 {"Rho1", Use::received, 2},
                                 {"Rho2", Use::received, 2}};
constexpr Signal kImuSignals[] = {{"Speed", Use::received, 1},
                                  {"Direction", Use::received, 1},
                                  {"YawRate", Use::received, 1},
                                  {"Counter", Use::received, 1, 2}};

std::span<const Signal> signals_of(Kind kind) {
  switch (kind) {
    case Kind::wheel: return kWheel;
    case Kind::steering: return kSteering;
    case Kind::io: return kIoSignals;
    case Kind::imu: break;
  }
  return kImuSignals;
}

std::string hex(unsigned value, int digits) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%0*X", digits, value);
  return text;
}

Field field_of(const Signal& signal, const canopen::Description& d,
               std::vector<std::string>& errors) {
  const std::string name = std::string("signal ") + signal.name;
  const canopen::DescribedSignal* described = d.signal(signal.name);
  if (described == nullptr) {
    if (!signal.optional) errors.push_back(name + " is missing in [LssSignals]");
    return {};
  }
  const canopen::DescribedObject* object = d.find(described->index, described->sub);
  if (object == nullptr) return {};  // reported already
  const std::string where = name + ": object " + hex(object->index, 4);
  if (object->bytes == 0 || (signal.bytes != 0 && signal.bytes != object->bytes))
    errors.push_back(where + " must be an integer of " +
                     (signal.bytes != 0 ? std::to_string(signal.bytes) : "1, 2 or 4") + " bytes");
  if (signal.use != Use::written && !object->mappable)
    errors.push_back(where + " cannot be mapped into a PDO");
  if (signal.use == Use::received ? !object->readable : !object->writable)
    errors.push_back(where +
                     (signal.use == Use::received ? " cannot be read" : " cannot be written"));
  if (signal.use == Use::written && !(described->unit > 0))
    errors.push_back(where + ": its unit must be above 0");
  return {object->index, object->sub, object->bytes, object->is_signed, described->unit};
}

// Set up by the master itself.
bool of_master(std::uint16_t index) {
  return index <= 0x1014 || index == canopen::kConsumerHeartbeat ||
         index == canopen::kProducerHeartbeat || (index >= 0x1200 && index < 0x1C00);
}

void add_written(const canopen::Description& d, Profile& p, std::vector<std::string>& errors) {
  std::size_t count = 0;
  for (const canopen::DescribedObject& o : d.objects) {
    const bool by_signal = std::ranges::any_of(p.field, [&](const Field& f) {
      return f.bytes != 0 && f.index == o.index && f.sub == o.sub;
    });
    if (!o.value || by_signal || of_master(o.index)) continue;
    if (!o.writable) {
      errors.push_back("object " + hex(o.index, 4) + " has a ParameterValue and cannot be written");
      continue;
    }
    if (count == kMostWritten) {
      errors.push_back("more than 8 objects have a ParameterValue");
      return;
    }
    p.entries[count++] = {o.index, o.sub, o.bytes, *o.value, o.index < 0x2000};
  }
}

// Without these a drive would go on or roll when the master is lost, roll after a quick stop, or be
// in another mode.
void check_drive(const canopen::Description& d, unsigned mode, std::vector<std::string>& errors) {
  const auto value = [&](std::uint16_t index) -> std::int64_t {
    const canopen::DescribedObject* object = d.find(index, 0);
    return object != nullptr && object->value ? static_cast<std::int64_t>(*object->value) : -1;
  };
  if (value(canopen::kAbortConnection) != 3)
    errors.push_back(
        "object 0x6007 needs the ParameterValue 3, quick stop: with another one the drive goes on "
        "or rolls when the master is lost");
  if (value(canopen::kQuickStopOption) < 5 || value(canopen::kQuickStopOption) > 8)
    errors.push_back(
        "object 0x605A needs a ParameterValue of 5 to 8, stop and hold: with another one the drive "
        "rolls after a quick stop");
  if (value(canopen::kModeOfOperation) != mode)
    errors.push_back("object 0x6060 needs the ParameterValue " + std::to_string(mode) +
                     (mode == 3 ? ", profile velocity" : ", profile position"));
}

}  // namespace

Profile make_profile(Kind kind, const canopen::Description& d, std::vector<std::string>& errors) {
  Profile p;
  const canopen::DescribedObject* type = d.find(canopen::kDeviceType, 0);
  if (type != nullptr && (type->value || type->by_itself)) {
    p.device_type = type->value ? *type->value : *type->by_itself;
  } else {
    errors.push_back("object 0x1000, the device type, has no value");
  }
  std::array<unsigned, 4> bytes{};  // of each PDO from the node
  const std::span<const Signal> all = signals_of(kind);
  for (std::size_t i = 0; i < all.size(); ++i) {
    p.field[i] = field_of(all[i], d, errors);
    if (all[i].use == Use::received) bytes[all[i].pdo] += p.field[i].bytes;
  }
  for (unsigned pdo = 1; pdo < bytes.size(); ++pdo) {
    if (bytes[pdo] > 8)
      errors.push_back("the signals of TPDO" + std::to_string(pdo) + " have more than 8 bytes");
  }
  add_written(d, p, errors);
  if (kind == Kind::wheel) check_drive(d, 3, errors);
  if (kind == Kind::steering) check_drive(d, 1, errors);
  return p;
}

Profile make_profile(Kind kind, std::string_view text, std::vector<std::string>& errors) {
  const canopen::ReadDescription read = canopen::read_description(text);
  if (read.errors.empty()) return make_profile(kind, read.description, errors);
  errors.insert(errors.end(), read.errors.begin(), read.errors.end());
  return {};
}

const Profiles& default_profiles() {
  static const Profiles kShipped = [] {
    Profiles profiles;
    std::vector<std::string> errors;  // a test reads them
    for (std::size_t i = 0; i < kKinds; ++i)
      profiles[i] = make_profile(static_cast<Kind>(i), devices::kTexts[i], errors);
    return profiles;
  }();
  return kShipped;
}

}  // namespace lss::ardito
