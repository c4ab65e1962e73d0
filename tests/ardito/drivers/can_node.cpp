#include "tests/ardito/drivers/can_node.h"

#include <algorithm>
#include <utility>

#include "tests/support/can_frames.h"

namespace lss::testing_support {
namespace {

constexpr TimeNs kNever = INT64_MAX;
constexpr TimeNs kAnswer = kMillisecond;

constexpr std::uint32_t key(std::uint32_t index, std::uint32_t sub = 0) { return index << 8 | sub; }

std::vector<std::uint8_t> little_endian(std::uint32_t value, int bytes) {
  std::vector<std::uint8_t> data;
  for (int i = 0; i < bytes; ++i) data.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  return data;
}

std::uint32_t read(const std::uint8_t* data, int bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < bytes; ++i) value |= std::uint32_t{data[i]} << (8 * i);
  return value;
}

}  // namespace

CanNode::CanNode(Kind of, std::uint8_t number) : kind(of), id(number) { reset_objects(); }

void CanNode::reset_objects() {
  objects = {{key(0x1000), {4, 0}},    {key(0x1001), {1, 0}}, {key(0x1015), {2, 0}},
             {key(0x1016, 1), {4, 0}}, {key(0x1017), {2, 0}}, {key(0x1029, 1), {1, 0}}};
  const auto pdos = [this](std::uint32_t parameters, std::uint32_t mapping, int count) {
    for (std::uint32_t n = 0; n < static_cast<std::uint32_t>(count); ++n) {
      objects[key(parameters + n, 1)] = {4, 0x8000'0000};
      objects[key(parameters + n, 2)] = {1, 0};
      objects[key(parameters + n, 3)] = {2, 0};
      objects[key(parameters + n, 5)] = {2, 0};
      objects[key(mapping + n, 0)] = {1, 0};
      for (std::uint32_t sub = 1; sub <= 8; ++sub) objects[key(mapping + n, sub)] = {4, 0};
    }
  };
  pdos(0x1400, 0x1600, kind == Kind::imu ? 0 : 1);
  pdos(0x1800, 0x1A00, kind == Kind::wheel ? 3 : kind == Kind::imu ? 1 : 2);
  const auto add = [this](std::uint32_t k, int bytes, std::uint32_t value = 0) {
    objects[k] = {bytes, value};
  };
  if (kind == Kind::wheel || kind == Kind::steering) {
    object(0x1000) = kind == Kind::wheel ? 0x0002'0192 : 0x0004'0192;
    for (const std::uint32_t i : {0x6007u, 0x605Au, 0x6040u, 0x6041u, 0x6078u}) add(key(i), 2);
    for (const std::uint32_t i : {0x6083u, 0x6084u, 0x6085u}) add(key(i), 4);
    add(key(0x6060), 1);
  }
  if (kind == Kind::wheel) {
    for (const std::uint32_t i : {0x60FFu, 0x606Cu}) add(key(i), 4);
    for (const std::uint32_t sub : {1u, 2u}) add(key(0x2100, sub), 4);
    add(key(0x2101, 1), 2, 253);
    add(key(0x2101, 2), 2, 2405);
  } else if (kind == Kind::steering) {
    for (const std::uint32_t i : {0x607Au, 0x6064u, 0x6081u}) add(key(i), 4);
    add(key(0x2100, 3), 4);
  } else if (kind == Kind::io) {
    object(0x1000) = 0x0007'0191;
    for (const std::uint32_t i : {0x6200u, 0x6206u, 0x6207u}) add(key(i, 1), 1);
    add(key(0x6000, 1), 1, 2);
    for (const std::uint32_t sub : {1u, 2u, 3u}) add(key(0x6401, sub), 2);
  } else {
    object(0x1000) = 0x0001'0000;
    for (const std::uint32_t sub : {1u, 2u, 3u, 4u}) add(key(0x2110, sub), 2);
  }
}

void CanNode::reboot(TimeNs now, TimeNs takes) {
  const std::uint32_t device = object(0x1000);
  reset_objects();
  objects.insert(added.begin(), added.end());
  object(0x1000) = device;
  nmt = Nmt::booting;
  drive = Drive::disabled;
  last_word_ = 0;
  acknowledged_ = watches_ = master_lost = false;
  target_ = 0;
  boot_ns_ = now + takes;
  heartbeat_ns_ = health_ns_ = kNever;
}

// Its state stays: a drive holds position, outputs stay.
void CanNode::reset_communication(TimeNs now) {
  set_nmt(Nmt::pre_operational);
  const Drive holds = drive;
  const std::uint32_t outputs = kind == Kind::io ? object(0x6200, 1) : 0;
  reboot(now);
  drive = holds;
  if (kind == Kind::io) object(0x6200, 1) = outputs;
}

void CanNode::set_nmt(Nmt to) {
  if (nmt == Nmt::operational && to != nmt && drive == Drive::enabled) stop();
  if (nmt != Nmt::operational && to == Nmt::operational) health_ns_ = 0;
  nmt = to;
}

void CanNode::heartbeat(TimeNs now) {
  const TimeNs period = object(0x1017) * kMillisecond;
  heartbeat_ns_ = period > 0 ? now + period : kNever;
  if (period > 0) send(0x700u + id, {static_cast<std::uint8_t>(nmt)}, now);
}

TimeNs CanNode::next_wake() const {
  if (!powered) return kNever;
  if (nmt == Nmt::booting) return boot_ns_;
  TimeNs wake = heartbeat_ns_;
  if (nmt == Nmt::operational && kind == Kind::wheel) wake = std::min(wake, health_ns_);
  if (watches_) wake = std::min(wake, master_ns_);
  return wake;
}

void CanNode::run(TimeNs now) {
  if (!powered || now < next_wake()) return;
  if (nmt == Nmt::booting) {
    nmt = Nmt::pre_operational;
    return send(0x700u + id, {0}, now);
  }
  if (watches_ && now >= master_ns_) {
    watches_ = false;
    master_lost = true;
    send_emcy(0x8130, 0x11, now);
    if (kind == Kind::io && (object(0x6206, 1) & 0x40) != 0) {
      object(0x6200, 1) = (object(0x6200, 1) & 0xBF) | (object(0x6207, 1) & 0x40);
    }
    set_nmt(Nmt::pre_operational);
  }
  if (now >= heartbeat_ns_) heartbeat(now);
  if (nmt == Nmt::operational && kind == Kind::wheel && now >= health_ns_) {
    health_ns_ = now + kSecond;
    if (object(0x1802, 5) == 1000) send_tpdo(3, now);
  }
}

void CanNode::receive(const CanFrame& frame, TimeNs now) {
  if (deaf || !powered || nmt == Nmt::booting) return;
  if (frame.id == 0x000) {
    if (frame.data[1] != 0 && frame.data[1] != id) return;
    switch (frame.data[0]) {
      case 0x01: return set_nmt(Nmt::operational);
      case 0x02: return set_nmt(Nmt::stopped);
      case 0x80: return set_nmt(Nmt::pre_operational);
      case 0x82: return reset_communication(now);
      default: return reboot(now);
    }
  }
  if (frame.id == 0x080) {
    if (nmt == Nmt::operational) tpdos(now, 1);
  } else if (frame.id == 0x200u + id) {
    if (nmt == Nmt::operational) rpdo(1, frame, now);
  } else if (frame.id == 0x600u + id) {
    if (nmt != Nmt::stopped) sdo(frame, now);
  } else if (frame.id == 0x700u + (object(0x1016, 1) >> 16)) {
    watches_ = true;
    master_ns_ = now + (object(0x1016, 1) & 0xFFFF) * kMillisecond;
  }
}

void CanNode::sdo(const CanFrame& frame, TimeNs now) {
  if (ignored_requests > 0) {
    --ignored_requests;
    return;
  }
  const std::uint8_t command = frame.data[0];
  if (command == 0x80) return;
  const std::uint32_t k = key(read(&frame.data[1], 2), frame.data[3]);
  std::vector<std::uint8_t> answer(frame.data.begin(), frame.data.begin() + 4);
  std::uint32_t code = 0;
  std::uint32_t value = 0;
  if (!objects.contains(k)) {
    code = 0x0602'0000;
  } else if (command == 0x40) {
    const Object& o = objects[k];
    answer[0] = static_cast<std::uint8_t>(0x43 | (4 - o.bytes) << 2);
    value = o.value;
  } else if ((command & 0xE3) == 0x23) {
    code = write(k, 4 - (command >> 2 & 3), read(&frame.data[4], 4));
    answer[0] = 0x60;
    if (code == 0 && k == key(0x1017)) heartbeat(now);
  } else {
    code = 0x0504'0001;
  }
  if (code != 0) {
    answer[0] = 0x80;
    value = code;
  }
  for (const std::uint8_t byte : little_endian(value, 4)) answer.push_back(byte);
  send(0x580u + id, answer, now);
}

// 0, or an abort code. A mapping can be changed while its PDO is invalid and maps nothing.
std::uint32_t CanNode::write(std::uint32_t k, int bytes, std::uint32_t value) {
  Object& o = objects[k];
  if (refused.contains(k)) return 0x0609'0030;
  if (bytes != o.bytes) return 0x0607'0010;
  const std::uint32_t index = k >> 8, sub = k & 0xFF, kind_of = index & 0xFFFC;
  if (kind_of == 0x1600 || kind_of == 0x1A00) {
    const std::uint32_t parameters = index - 0x200;
    const bool valid = (objects.at(key(parameters, 1)).value & 0x8000'0000) == 0;
    if (valid || nmt != Nmt::pre_operational) return 0x0601'0000;
    if (sub > 0 && objects.at(key(index)).value != 0) return 0x0601'0000;
    if (sub > 0) {
      const auto mapped = objects.find(value >> 8);
      if (mapped == objects.end()) return 0x0602'0000;
      if (mapped->second.bytes * 8 != static_cast<int>(value & 0xFF)) return 0x0604'0041;
    }
  }
  if ((kind_of == 0x1400 || kind_of == 0x1800) && sub > 1 &&
      (objects.at(key(index, 1)).value & 0x8000'0000) == 0) {
    return 0x0601'0000;
  }
  o.value = value;
  return 0;
}

void CanNode::rpdo(int number, const CanFrame& frame, TimeNs now) {
  const auto n = static_cast<std::uint32_t>(number - 1);
  if (!objects.contains(key(0x1400 + n, 1)) || object(0x1400, 1) != frame.id) return;
  std::size_t at = 0;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> values;
  for (std::uint32_t sub = 1; sub <= objects.at(key(0x1600 + n)).value; ++sub) {
    const std::uint32_t mapped = objects.at(key(0x1600 + n, sub)).value;
    const int bytes = static_cast<int>(mapped & 0xFF) / 8;
    if (at + static_cast<std::size_t>(bytes) <= frame.size) {
      values.emplace_back(mapped >> 8, read(&frame.data[at], bytes));
    }
    at += static_cast<std::size_t>(bytes);
  }
  if (at != frame.size) return send_emcy(0x8210, 0x11, now);
  for (const auto& [k, value] : values) objects.at(k).value = value;
  if (kind != Kind::io && !ignores_controlword) controlword();
}

void CanNode::stop() {
  drive = Drive::quick_stop;
  ++quick_stops;
  target_ = kind == Kind::wheel ? 0 : target_;
}

void CanNode::controlword() {
  const auto word = static_cast<std::uint16_t>(object(0x6040));
  const bool rises = (word & 0x80) != 0 && (last_word_ & 0x80) == 0;
  const bool new_set_point = (word & 0x10) != 0 && (last_word_ & 0x10) == 0;
  last_word_ = word;
  if (drive == Drive::fault) {
    if (rises) drive = Drive::disabled;
  } else if ((word & 0x02) == 0) {
    drive = Drive::disabled;
  } else if ((word & 0x06) == 0x02) {
    if (drive == Drive::enabled)
      stop();
    else if (drive != Drive::quick_stop)
      drive = Drive::disabled;
  } else if (drive != Drive::quick_stop) {
    if ((word & 0x07) == 0x06) {
      drive = Drive::ready;
    } else if ((word & 0x0F) == 0x07 && drive != Drive::disabled) {
      drive = Drive::switched_on;
    } else if ((word & 0x0F) == 0x0F && (drive == Drive::switched_on || drive == Drive::enabled)) {
      drive = Drive::enabled;
    }
  }
  if ((word & 0x10) == 0) acknowledged_ = false;
  if (drive == Drive::enabled && kind == Kind::wheel) {
    target_ = static_cast<std::int32_t>(object(0x60FF));
  } else if (drive == Drive::enabled && new_set_point && (word & 0x20) != 0) {
    target_ = static_cast<std::int32_t>(object(0x607A));
    acknowledged_ = true;
    ++set_points;
  }
}

void CanNode::fault(std::uint16_t code, TimeNs now) {
  drive = Drive::fault;
  send_emcy(code, 0x21, now);
}

void CanNode::update() {
  if (kind == Kind::imu) object(0x2110, 4) = (object(0x2110, 4) + 1) & 0xFFFF;
  if (kind != Kind::wheel && kind != Kind::steering) return;
  std::uint32_t word = 0;
  switch (drive) {
    case Drive::disabled: word = 0x0250; break;
    case Drive::ready: word = 0x0231; break;
    case Drive::switched_on: word = 0x0233; break;
    case Drive::enabled: word = 0x0237; break;
    case Drive::quick_stop: word = 0x0217; break;
    case Drive::fault: word = 0x0218; break;
  }
  if (kind == Kind::steering && acknowledged_) word |= 0x1000;
  object(0x6041) = word;
  const std::int32_t turns = kind == Kind::steering || drive == Drive::enabled ? target_ : 0;
  if (kind == Kind::wheel) {
    object(0x606C) = object(0x2100, 1) = static_cast<std::uint32_t>(turns);
    object(0x2100, 2) = static_cast<std::uint32_t>(turns * 2);  // 100 / 50
  } else {
    object(0x6064) = static_cast<std::uint32_t>(turns);
    object(0x2100, 3) = static_cast<std::uint32_t>(turns / 50);
  }
}

void CanNode::tpdos(TimeNs now, int of_type) {
  update();
  for (int number = 1; number <= 3; ++number) {
    const std::uint32_t parameters = 0x1800 + static_cast<std::uint32_t>(number) - 1;
    if (!objects.contains(key(parameters, 2))) continue;
    const auto type = static_cast<int>(objects.at(key(parameters, 2)).value);
    if (type == of_type || type == 254) send_tpdo(number, now);
  }
}

void CanNode::send_tpdo(int number, TimeNs now) {
  const auto n = static_cast<std::uint32_t>(number - 1);
  const std::uint32_t cob_id = objects.at(key(0x1800 + n, 1)).value;
  if ((cob_id & 0x8000'0000) != 0) return;
  std::vector<std::uint8_t> data;
  for (std::uint32_t sub = 1; sub <= objects.at(key(0x1A00 + n)).value; ++sub) {
    const std::uint32_t mapped = objects.at(key(0x1A00 + n, sub)).value;
    for (const std::uint8_t byte :
         little_endian(objects.at(mapped >> 8).value, static_cast<int>(mapped & 0xFF) / 8)) {
      data.push_back(byte);
    }
  }
  if (shorter_pdos > 0) {
    --shorter_pdos;
    data.pop_back();
  }
  send(cob_id & 0x7FF, data, now);
}

void CanNode::send_emcy(std::uint16_t code, std::uint8_t error_register, TimeNs now) {
  send(0x080u + id,
       {static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code >> 8), error_register, 0, 0,
        0, 0, 0},
       now);
}

void CanNode::send(std::uint32_t cob_id, const std::vector<std::uint8_t>& data, TimeNs now) {
  if (mute || !powered) return;
  out_.push_back(frame(cob_id, data, now + kAnswer));
}

std::vector<CanFrame> CanNode::take() { return std::exchange(out_, {}); }

}  // namespace lss::testing_support
