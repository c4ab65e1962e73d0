#include "tools/lss-sim/canopen/node.h"

#include <algorithm>

#include "tools/lss-sim/canopen/wire.h"

namespace lss::sim::nodes {
namespace {

constexpr std::uint8_t kMaster = 0x7F;
constexpr std::uint16_t kRpdo = 0x1400, kRpdoMapping = 0x1600;
constexpr std::uint16_t kTpdo = 0x1800, kTpdoMapping = 0x1A00;
constexpr std::uint16_t kHeartbeatLost = 0x8130, kPdoLength = 0x8210;

// Commands of NMT.
constexpr std::uint8_t kStart = 0x01, kStop = 0x02, kPreOperational = 0x80, kResetNode = 0x81,
                       kResetCommunication = 0x82;

constexpr Object kCommunication[] = {
    {.index = 0x1001, .bytes = 1, .mappable = true},
    {.index = 0x1003, .bytes = 1, .access = rw},  // writing 0 forgets the history
    {.index = 0x1003, .sub = 1},
    {.index = 0x1003, .sub = 2},
    {.index = 0x1003, .sub = 3},
    {.index = 0x1003, .sub = 4},
    {.index = 0x1005, .initial = 0x80},
    {.index = 0x1015, .bytes = 2, .access = rw},
    {.index = 0x1016, .bytes = 1, .initial = 1},
    {.index = 0x1016, .sub = 1, .access = rw},
    {.index = 0x1017, .bytes = 2, .access = rw},
    {.index = 0x1018, .bytes = 1, .initial = 4},
    {.index = 0x1018, .sub = 1, .initial = 0},  // no vendor
    {.index = 0x1018, .sub = 4, .initial = 1},
    {.index = 0x1029, .bytes = 1, .initial = 1},
    {.index = 0x1029, .sub = 1, .bytes = 1, .access = rw, .min = 0, .max = 2},
};

// Bits of the error register besides bit 0 (ICD section 11).
std::uint8_t register_of(std::uint16_t code) {
  switch (code >> 12) {
    case 0x0: return 0;
    case 0x2: return 1 << 1;
    case 0x3: return 1 << 2;
    case 0x4: return 1 << 3;
    case 0x7: return 1 << 5;
    case 0x8: return code >> 8 == 0x86 ? 1 << 5 : 1 << 4;
    default: return 0;
  }
}

}  // namespace

Node::Node(const Identity& identity, std::size_t rpdos, std::size_t tpdos,
           std::span<const Object> objects, unsigned seed)
    : random_(seed), id_(identity.id), device_type_(identity.device_type) {
  objects_.add({.index = 0x1000});
  objects_.add({.index = 0x1014, .initial = 0x80 + id_});
  objects_.add({.index = 0x1018, .sub = 2, .initial = identity.product});
  objects_.add({.index = 0x1018, .sub = 3, .initial = identity.revision});
  objects_.add(kCommunication);
  const auto add_pdo = [&](std::vector<Pdo>& pdos, std::uint16_t base, std::uint16_t mapping_base,
                           std::uint32_t cob_id) {
    const auto n = static_cast<std::uint16_t>(pdos.size());
    const auto parameters = static_cast<std::uint16_t>(base + n);
    const auto mapping = static_cast<std::uint16_t>(mapping_base + n);
    objects_.add({.index = parameters, .bytes = 1, .initial = 5});
    objects_.add({.index = parameters,
                  .sub = 1,
                  .access = rw,
                  .initial = kInvalid | (cob_id + 0x100u * n + id_)});
    objects_.add({.index = parameters, .sub = 2, .bytes = 1, .access = rw, .initial = 255});
    objects_.add({.index = parameters, .sub = 3, .bytes = 2, .access = rw});
    objects_.add({.index = parameters, .sub = 5, .bytes = 2, .access = rw});
    objects_.add({.index = mapping, .bytes = 1, .access = rw});
    for (std::uint8_t i = 1; i <= kMostMapped; ++i) {
      objects_.add({.index = mapping, .sub = i, .access = rw});
    }
    pdos.push_back({.parameters = parameters, .mapping = mapping});
  };
  for (std::size_t i = 0; i < rpdos; ++i) add_pdo(rpdos_, kRpdo, kRpdoMapping, 0x200);
  for (std::size_t i = 0; i < tpdos; ++i) {
    add_pdo(tpdos_, kTpdo, kTpdoMapping, kNoRemote | 0x180);
  }
  objects_.add(objects);
  begin_boot();
}

void Node::power_on() {
  begin_boot();
  reset();
}

void Node::begin_boot() {
  nmt_ = Nmt::initialising;
  boot_left_ms_ = kBoot_ms + 10 * (id_ % 16);
  objects_.reset();
  outbox_.clear();
  to_tell_.clear();
  active_.clear();
  watching_ = false;
  heartbeat_ms_ = unheard_ms_ = emcy_ms_ = 0;
  for (Pdo& pdo : tpdos_) pdo = {.parameters = pdo.parameters, .mapping = pdo.mapping};
}

void Node::enter(Nmt state, bool communication_error) {
  const bool left = nmt_ == Nmt::operational && state != Nmt::operational;
  nmt_ = state;
  if (left) left_operational(communication_error);
}

void Node::command(std::uint8_t command) {
  switch (command) {
    case kStart: return enter(Nmt::operational, false);
    case kStop: return enter(Nmt::stopped, false);
    case kPreOperational: return enter(Nmt::pre_operational, false);
    case kResetNode: return power_on();
    case kResetCommunication: enter(Nmt::initialising, false); return begin_boot();
    default: return;
  }
}

void Node::receive(const CanFrame& frame) {
  if (nmt_ == Nmt::initialising || faults.silent) return;
  if (frame.extended || frame.remote || frame.error) return;
  const std::span data(frame.data.data(), frame.size);
  if (frame.id == 0x000) {
    if (frame.size == 2 && (data[1] == 0 || data[1] == id_)) command(data[0]);
  } else if (frame.id == 0x080) {
    if (frame.size == 0) sync();
  } else if (frame.id == 0x700u + kMaster) {
    if (frame.size == 1) heard_heartbeat();
  } else if (frame.id == 0x600u + id_) {
    if (frame.size == 8 && nmt_ != Nmt::stopped) serve_sdo(frame);
  } else if (nmt_ == Nmt::operational) {
    for (Pdo& pdo : rpdos_) {
      if (valid(pdo) && (objects_.get(pdo.parameters, 1) & kIdBits) == frame.id) {
        take_rpdo(pdo, frame);
      }
    }
  }
}

std::optional<CanFrame> Node::send() {
  if (outbox_.empty()) return std::nullopt;
  const CanFrame frame = outbox_.front();
  outbox_.pop_front();
  return frame;
}

void Node::put(std::uint32_t id, std::span<const std::uint8_t> data) {
  if (faults.silent) return;
  CanFrame frame{.id = id, .size = static_cast<std::uint8_t>(data.size())};
  std::ranges::copy(data, frame.data.begin());
  outbox_.push_back(frame);
}

void Node::step() {
  if (nmt_ == Nmt::initialising) {
    if (--boot_left_ms_ > 0) return tick();
    nmt_ = Nmt::pre_operational;
    put(0x700u + id_, std::array<std::uint8_t, 1>{0});
  }
  objects_.set(0x1000, 0, claimed_type_ != 0 ? claimed_type_ : device_type_);
  tick();
  watch_master();
  for (Pdo& pdo : tpdos_) ++pdo.since_ms;
  serve_timers();
  serve_emcy();
  misbehave();
  const auto period_ms = static_cast<int>(objects_.get(0x1017, 0));
  if (++heartbeat_ms_ >= period_ms && period_ms > 0) {
    heartbeat_ms_ = 0;
    put(0x700u + id_, std::array{static_cast<std::uint8_t>(nmt_)});
  }
}

void Node::heard_heartbeat() {
  const std::uint32_t entry = objects_.get(0x1016, 1);
  if ((entry >> 16 & 0x7F) != kMaster || (entry & 0xFFFF) == 0) return;
  watching_ = true;
  unheard_ms_ = 0;
  settle(kHeartbeatLost);
}

void Node::watch_master() {
  const auto limit_ms = static_cast<int>(objects_.get(0x1016, 1) & 0xFFFF);
  if (!watching_ || ++unheard_ms_ < limit_ms) return;
  watching_ = false;  // until its next heartbeat
  raise(kHeartbeatLost);
  const std::uint32_t behaviour = objects_.get(0x1029, 1);
  if (nmt_ == Nmt::operational && behaviour == 0) enter(Nmt::pre_operational, true);
  if (behaviour == 2) enter(Nmt::stopped, true);
}

// ---- PDO

bool Node::valid(const Pdo& pdo) const { return (objects_.get(pdo.parameters, 1) & kInvalid) == 0; }

std::size_t Node::mapped_bits(const Pdo& pdo) const {
  std::size_t bits = 0;
  const std::uint32_t count = objects_.get(pdo.mapping, 0);
  for (std::uint8_t i = 1; i <= count; ++i) bits += unpack(objects_.get(pdo.mapping, i)).bits;
  return bits;
}

void Node::take_rpdo(Pdo& pdo, const CanFrame& frame) {
  if (frame.size * 8u != mapped_bits(pdo)) return raise(kPdoLength);
  settle(kPdoLength);
  std::size_t at = 0;
  const std::uint32_t count = objects_.get(pdo.mapping, 0);
  for (std::uint8_t i = 1; i <= count; ++i) {
    const Mapped mapped = unpack(objects_.get(pdo.mapping, i));
    const std::span bytes(&frame.data[at], mapped.bits / 8u);
    const std::uint32_t value = little_endian(bytes);
    at += bytes.size();
    if (objects_.check(mapped.index, mapped.sub, bytes.size(), value) != kDone) continue;
    objects_.set(mapped.index, mapped.sub, value);
  }
  // All values are stored before any takes effect: a controlword belongs to its target.
  for (std::uint8_t i = 1; i <= count; ++i) {
    const Mapped mapped = unpack(objects_.get(pdo.mapping, i));
    written(mapped.index, mapped.sub);
  }
}

void Node::send_tpdo(Pdo& pdo) {
  std::array<std::uint8_t, 8> data{};
  std::size_t at = 0;
  const std::uint32_t count = objects_.get(pdo.mapping, 0);
  for (std::uint8_t i = 1; i <= count; ++i) {
    const Mapped mapped = unpack(objects_.get(pdo.mapping, i));
    const std::size_t bytes = mapped.bits / 8u;
    to_little_endian(objects_.get(mapped.index, mapped.sub), std::span(data).subspan(at, bytes));
    at += bytes;
  }
  const int size = std::clamp(static_cast<int>(at) + faults.longer_pdos, 0, 8);
  put(objects_.get(pdo.parameters, 1) & kIdBits,
      std::span(data).first(static_cast<std::size_t>(size)));
  pdo.since_ms = pdo.syncs = 0;
  pdo.due = false;
}

void Node::sync() {
  if (nmt_ != Nmt::operational) return;
  count_sync();
  measure();
  for (Pdo& pdo : tpdos_) {
    if (!valid(pdo)) continue;
    const std::uint32_t type = type_of(pdo);
    if (type >= 1 && type <= 240 && ++pdo.syncs >= static_cast<int>(type)) send_tpdo(pdo);
    if (type == 254) pdo.due = true;
  }
  serve_timers();
}

// PDOs sent on change and by timer, but not within their inhibit time (0.1 ms on the bus).
void Node::serve_timers() {
  for (Pdo& pdo : tpdos_) {
    if (nmt_ != Nmt::operational || !valid(pdo) || type_of(pdo) < 254) continue;
    const auto inhibit_ms = static_cast<int>((objects_.get(pdo.parameters, 3) + 9) / 10);
    const auto timer_ms = static_cast<int>(objects_.get(pdo.parameters, 5));
    const bool elapsed = timer_ms > 0 && pdo.since_ms >= timer_ms;
    if ((!pdo.due && !elapsed) || pdo.since_ms <= inhibit_ms) continue;
    measure();
    send_tpdo(pdo);
  }
}

// ---- EMCY

void Node::raise(std::uint16_t code) {
  if (std::ranges::find(active_, code) != active_.end()) return;
  active_.push_back(code);
  to_tell_.push_back({code, static_cast<std::uint8_t>(1 | register_of(code))});
  for (std::uint8_t sub = 4; sub > 1; --sub) {
    objects_.set(0x1003, sub, objects_.get(0x1003, static_cast<std::uint8_t>(sub - 1)));  // older
  }
  objects_.set(0x1003, 1, code);
  objects_.set(0x1003, 0, std::min<std::uint32_t>(4, objects_.get(0x1003, 0) + 1));
}

void Node::settle(std::uint16_t code) {
  if (std::erase(active_, code) > 0 && active_.empty()) to_tell_.push_back({0, 0});
}

void Node::inject_emcy(std::uint16_t code, bool attach) { attach ? raise(code) : settle(code); }

void Node::serve_emcy() {
  std::uint8_t bits = 0;
  for (const std::uint16_t code : active_) bits |= static_cast<std::uint8_t>(1 | register_of(code));
  objects_.set(0x1001, 0, bits);
  const auto inhibit_ms = static_cast<int>(objects_.get(0x1015, 0) + 9) / 10;
  if (++emcy_ms_ < inhibit_ms || to_tell_.empty() || nmt_ == Nmt::stopped) return;
  const Emcy emcy = to_tell_.front();
  to_tell_.pop_front();
  emcy_ms_ = 0;
  put(0x080u + id_,
      std::array<std::uint8_t, 8>{static_cast<std::uint8_t>(emcy.code),
                                  static_cast<std::uint8_t>(emcy.code >> 8), emcy.bits});
}

void Node::misbehave() {
  const auto owed = [](double& account, double rate_1_s) {
    account = rate_1_s > 0 ? account + rate_1_s * 1e-3 : 0;
    const int frames = static_cast<int>(account);
    account -= frames;
    return frames;
  };
  std::uniform_int_distribution<unsigned> any(0, 255);
  for (int n = owed(babble_, faults.babble_1_s); n > 0; --n) {
    std::array<std::uint8_t, 8> noise;
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(any(random_));
    put(0x180u + 0x100u * (any(random_) % 4) + id_, noise);
  }
  for (int n = owed(storm_, faults.emcy_storm_1_s); n > 0; --n) {
    put(0x080u + id_,
        std::array<std::uint8_t, 8>{static_cast<std::uint8_t>(any(random_)), 0xFF, 1});
  }
}

}  // namespace lss::sim::nodes
