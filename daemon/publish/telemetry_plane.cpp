#include "daemon/publish/telemetry_plane.h"

#include <dds/ddsc/dds_loan_api.h>
#include <pthread.h>
#include <stdlib.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstring>
#include <utility>

#include "daemon/publish/convert.h"
#include "daemon/runtime/clock.h"

namespace lss::dds {
namespace {

// RouDi drops a client whose keep-alive, sent every 300 ms, is late by 1.5 s (measured 2026-11), so
// a standstill of 1.2 s may be enough. By the machine's clock, also in simulated time.
constexpr TimeNs kStandstill_ns = kSecond;
constexpr auto kTick = std::chrono::milliseconds(100);

using Key = decltype(lss_Status::vehicle_id);  // every type begins with it; the time follows

constexpr const char* kOffText = "not configured";
constexpr const char* kSecuredText = "off: dds.security is on, and shared memory is not encrypted";
constexpr const char* kOverriddenText = "switched off by CYCLONEDDS_URI";
constexpr const char* kActiveText = "telemetry goes by shared memory";
constexpr const char* kAbsentText =
    "no RouDi at start: telemetry by the network; start iox-roudi, then restart lssd";
constexpr const char* kHangsText =
    "RouDi hung at start: telemetry by the network; look after iox-roudi, restart lssd when idle";
constexpr const char* kLostText =
    "RouDi ended or was replaced: telemetry by the network; restart lssd when idle";
constexpr const char* kStandstillText =
    "stood still, RouDi may have dropped us: telemetry by the network; restart lssd when idle";

}  // namespace

TelemetryPlane::TelemetryPlane(Participant& participant, const TelemetryTopic& topic,
                               std::string vehicle_id, bool wanted)
    : participant_(participant),
      telemetry_topic_(topic),
      vehicle_id_(std::move(vehicle_id)),
      wanted_(wanted),
      telemetry_{dds::telemetry_topic(topic.vehicle, topic.descriptor), {}},
      timing_{common_topic(Kind::timing), {}},
      own_sample_(topic.size / sizeof(std::uint64_t) + 1) {}

TelemetryPlane::~TelemetryPlane() {
  leave_after_standstill();
  if (abandoned_) participant_.abandon();
}

Result<void> TelemetryPlane::open() {
  const auto& roudi = participant_.roudi();
  // Checked again: a shared-memory writer that finds no RouDi ends the process.
  const bool lives = roudi && find_roudi() == roudi;
  if (Result<void> opened = open_channels(lives ? Transport::best : Transport::network); !opened) {
    return opened;
  }
  if (dds_is_shared_memory_available(telemetry_.writer.get())) {
    standstill_.start();
    state_ = SharedMemory::active;
    text_ = kActiveText;
  } else if (wanted_ && participant_.enclave()) {
    text_ = kSecuredText;
  } else if (!wanted_ || lives) {
    text_ = lives ? kOverriddenText : kOffText;
  } else {
    state_ = roudi ? SharedMemory::lost : SharedMemory::absent;
    text_ = roudi ? kLostText : participant_.roudi_hangs() ? kHangsText : kAbsentText;
  }
  return {};
}

Result<void> TelemetryPlane::open_channels(Transport transport) {
  for (Channel* channel : {&telemetry_, &timing_}) {
    Result<Entity> writer = create_writer(participant_.get(), channel->topic, transport);
    if (!writer) return tl::unexpected(writer.error());
    channel->writer = std::move(*writer);
  }
  return {};
}

void TelemetryPlane::telemetry(const void* vehicle_telemetry) {
  TimeNs time = 0;
  write(telemetry_, own_sample_.data(), [&](void* sample) {
    std::memcpy(sample, vehicle_telemetry, telemetry_topic_.size);
    copy_text(vehicle_id_, *static_cast<Key*>(sample));
    std::memcpy(&time, static_cast<const char*>(sample) + sizeof(Key), sizeof time);
  });
  if (lockstep::on()) lockstep::said_telemetry(time);
}

void TelemetryPlane::timing(const TimingPoints& points) {
  lss_Timing own_sample;
  write(timing_, &own_sample,
        [&](void* sample) { to_dds(points, vehicle_id_, *static_cast<lss_Timing*>(sample)); });
}

// A loaned sample is filled in place, in shared memory. When slow subscribers hold all chunks there
// is none, and the sample is dropped as by a full ring.
template <class Fill>
void TelemetryPlane::write(Channel& channel, void* own_sample, Fill fill) {
  leave_after_standstill();
  void* sample = own_sample;
  if (state() == SharedMemory::active &&
      dds_loan_sample(channel.writer.get(), &sample) != DDS_RETCODE_OK) {
    ++dropped_;
    return;
  }
  fill(sample);
  leave_after_standstill();
  if (sample != own_sample && state() != SharedMemory::active) fill(sample = own_sample);
  if (dds_write(channel.writer.get(), sample) != DDS_RETCODE_OK) ++dropped_;
}

bool TelemetryPlane::watch() {
  leave_after_standstill();
  if (state() == SharedMemory::active && find_roudi() != participant_.roudi()) {
    text_ = kLostText;
    fall_back();
  }
  return std::exchange(changed_, false);
}

// Before every access to shared memory. A client that RouDi dropped must not access it again: its
// ports are freed and reused, and publishing through them ends the process
// ("POPO__CHUNK_LOCKING_ERROR").
void TelemetryPlane::leave_after_standstill() {
  if (state() == SharedMemory::active && standstill_.seen()) abandon();
}

void TelemetryPlane::Standstill::start() {
  last_ns_ = machine_ns();
  thread_ = std::jthread([this](const std::stop_token& stop) {
    ::pthread_setname_np(::pthread_self(), "standstill");
    std::unique_lock lock(mutex_);
    while (!waiting_.wait_for(lock, stop, kTick, [&] { return stop.stop_requested(); })) {
      if (seen()) seen_ = true;
      last_ns_ = machine_ns();
    }
  });
}

// In this order: what the thread has set `last_ns_` to since, it has set `seen_` before.
bool TelemetryPlane::Standstill::seen() const {
  const TimeNs last_ns = last_ns_;
  return machine_ns() - last_ns >= kStandstill_ns || seen_;
}

// Our mapping outlives RouDi, so the old writers can be deleted.
void TelemetryPlane::fall_back() {
  telemetry_.writer.reset();
  timing_.writer.reset();
  // Fails only when memory is exhausted; the following writes then count as dropped.
  static_cast<void>(open_channels(Transport::network));
  state_ = SharedMemory::lost;
  changed_ = true;
}

// Deleting writers or participant would access shared memory, and so would the exit of the process:
// iceoryx' runtime says goodbye to RouDi and waits for an answer that a dropped client never gets.
// So they stay, and the process exits without it. (The handler runs before the runtime's
// destructor, as it is registered after it.)
void TelemetryPlane::abandon() {
  abandoned_ = true;
  ::on_exit(
      [](int status, void*) {
        std::fflush(nullptr);
        ::_exit(status);
      },
      nullptr);
  telemetry_.writer.release();
  timing_.writer.release();
  text_ = kStandstillText;
  fall_back();
}

// Does not wait: RouDi may hang. It has to answer from one look to the next, as at the start, so
// that a daemon does not start again and again for one that is too slow.
bool TelemetryPlane::could_return() {
  const SharedMemory now = state();
  const auto roudi =
      now == SharedMemory::absent || now == SharedMemory::lost ? find_roudi() : std::nullopt;
  if (!roudi) {
    call_.reset();
    return false;
  }
  const bool answered = call_ && called_ == roudi && call_->taken();
  call_.emplace();
  called_ = roudi;
  return answered;
}

}  // namespace lss::dds
