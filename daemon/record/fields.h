#pragma once

// The members of plain structs, listed once: fields(v, x) names each member to the visitor v, so
// that records are written, read back, compared and shown by the same description. A vehicle
// describes its own structs in daemon/vehicles/NAME/record.h; those of the IDL are described by the
// build (cmake/idl_fields.py).
//
//   v("name", member)                 numbers, enums, arrays of them, structs with fields(), and
//                                     variants of such structs; arrays are std::array or of C
//   v.list("name", array, count)      the first `count` elements of an array; count is a member
//
// The writer allocates nothing.

#include <array>
#include <concepts>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

#include "daemon/cycle/supervisor.h"

namespace lss::record {

// T or const T.
template <class X, class T>
concept Like = std::same_as<std::remove_const_t<X>, T>;

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

// std::array, or an array of C.
template <class T>
concept Array = requires(T& x) {
  std::size(x);
  x[0];
};
// Characters up to the first NUL.
template <class T>
concept Text = Array<T> && std::same_as < std::remove_cvref_t<decltype(std::declval<T&>()[0])>,
char > ;

// Into a buffer; `size` is larger than the buffer when it was too small.
class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> buffer) noexcept : buffer_(buffer) {}
  std::size_t size() const noexcept { return size_; }
  bool fits() const noexcept { return size_ <= buffer_.size(); }

  template <class T>
  void operator()(const char*, const T& x) noexcept {
    put(x);
  }
  template <class T, std::size_t N>
  void list(const char*, const std::array<T, N>& x, const std::uint32_t& count) noexcept {
    put(count);
    for (std::uint32_t i = 0; i < count; ++i) put(x[i]);
  }

 private:
  template <class T>
  void put(const T& x) noexcept {
    if constexpr (Number<T>) {
      if (size_ + sizeof x <= buffer_.size()) std::memcpy(&buffer_[size_], &x, sizeof x);
      size_ += sizeof x;
    } else {
      fields(*this, x);
    }
  }
  template <Array T>
  void put(const T& x) noexcept {
    for (const auto& element : x) put(element);
  }
  template <class... T>
  void put(const std::variant<T...>& x) noexcept {
    put(static_cast<std::uint8_t>(x.index()));
    std::visit([this](const auto& alternative) { put(alternative); }, x);
  }

  std::span<std::uint8_t> buffer_;
  std::size_t size_ = 0;
};

// Out of a buffer. Broken input gives zeros and good() == false, never more than the buffer has.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> buffer) noexcept : buffer_(buffer) {}
  bool good() const noexcept { return good_; }
  bool at_end() const noexcept { return at_ == buffer_.size(); }
  std::size_t at() const noexcept { return at_; }

  template <class T>
  void operator()(const char*, T& x) noexcept {
    get(x);
  }
  template <class T, std::size_t N>
  void list(const char*, std::array<T, N>& x, std::uint32_t& count) noexcept {
    get(count);
    if (count > N) {
      count = 0;
      good_ = false;
    }
    for (std::uint32_t i = 0; i < count; ++i) get(x[i]);
  }

 private:
  template <class T>
  void get(T& x) noexcept {
    if constexpr (std::same_as<T, bool>) {  // any other byte in a bool would be undefined
      std::uint8_t byte = 0;
      get(byte);
      good_ = good_ && byte <= 1;
      x = byte != 0;
    } else if constexpr (Number<T>) {
      good_ = good_ && buffer_.size() - at_ >= sizeof x;
      if (!good_) return void(x = T{});
      std::memcpy(&x, &buffer_[at_], sizeof x);
      at_ += sizeof x;
    } else {
      fields(*this, x);
    }
  }
  template <Array T>
  void get(T& x) noexcept {
    for (auto& element : x) get(element);
  }
  template <class... T>
  void get(std::variant<T...>& x) noexcept {
    std::uint8_t index = 0;
    get(index);
    good_ = good_ && index < sizeof...(T);
    if (!good_) return;
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      ((I == index ? get(x.template emplace<I>()) : void()), ...);
    }
    (std::index_sequence_for<T...>());
  }

  std::span<const std::uint8_t> buffer_;
  std::size_t at_ = 0;
  bool good_ = true;
};

}  // namespace lss::record

// The structs that all vehicles share.
namespace lss {

template <class V, record::Like<Request> X>
void fields(V& v, X& x) {
  v("source", x.source);
  v("sequence", x.sequence);
  v("kind", x.kind);
  v("flags", x.flags);
  v("lease_ms", x.lease_ms);
  v("parameter", x.parameter);
  v("arrival_ns", x.arrival_ns);
  v("acknowledged", x.acknowledged);
  v("answered", x.answered);
}

template <class V, record::Like<Verdict> X>
void fields(V& v, X& x) {
  v("reason", x.reason);
  v("measured", x.measured);
  v("limit", x.limit);
  v("subject", x.subject);
}

template <class V, record::Like<Ack> X>
void fields(V& v, X& x) {
  v("source", x.source);
  v("sequence", x.sequence);
  v("kind", x.kind);
  v("phase", x.phase);
  v("verdict", x.verdict);
  v("time_ns", x.time_ns);
}

template <class V, record::Like<EventRecord> X>
void fields(V& v, X& x) {
  v("time_ns", x.time_ns);
  v("severity", x.severity);
  v("id", x.id);
  v("subject", x.subject);
  v("argument", x.argument);
}

template <class V, record::Like<FaultRecord> X>
void fields(V& v, X& x) {
  v("id", x.id);
  v("subject", x.subject);
  v("count", x.count);
  v("since_ns", x.since_ns);
}

template <class V, record::Like<TimingPoints> X>
void fields(V& v, X& x) {
  v("frame", x.frame);
  v("boundary_ns", x.boundary_ns);
  v("woken_ns", x.woken_ns);
  v("read_ns", x.read_ns);
  v("navigated_ns", x.navigated_ns);
  v("ready_ns", x.ready_ns);
  v("released_ns", x.released_ns);
  v("margin_ns", x.margin_ns);
  v("offset_ns", x.offset_ns);
  v("overruns", x.overruns);
  v("frames_skipped", x.frames_skipped);
  v("frames_held", x.frames_held);
  v("commands_repeated", x.commands_repeated);
  v("samples", x.samples);
}

template <class V, record::Like<Supervisor::Outbox> X>
void fields(V& v, X& x) {
  v.list("acks", x.acks, x.ack_count);
  v.list("events", x.events, x.event_count);
  v("dropped", x.dropped);
}

namespace lc {
template <class V, record::Like<ControllerState> X>
void fields(V& v, X& x) {
  v("state", x.state);
  v("mode", x.mode);
  v("goal", x.goal);
  v("flags", x.flags);
  v("links", x.links);
  v("strategy", x.strategy);
  v("silent", x.silent);
  v("unheard", x.unheard);
  v("isolated", x.isolated);
}
}  // namespace lc

template <class V, record::Like<SupervisorState::Active> X>
void fields(V& v, X& x) {
  v("source", x.source);
  v("sequence", x.sequence);
  v("kind", x.kind);
}

template <class V, record::Like<SupervisorState> X>
void fields(V& v, X& x) {
  v("controller", x.controller);
  v("authority", x.authority);
  v("detached", x.detached);
  v("lease_ns", x.lease_ns);
  v("heartbeat_ns", x.heartbeat_ns);
  v("contact_ns", x.contact_ns);
  v("active", x.active);
  v("faults", x.faults);
  v("fault_count", x.fault_count);
  v("resetting", x.resetting);
  v("age_ms", x.age_ms);
  v("silent_limit_ms", x.silent_limit_ms);
  v("sense", x.sense);
  v("commands_taken", x.commands_taken);
  v("ended_ns", x.ended_ns);
  v("another_daemon_ns", x.another_daemon_ns);
  v("commands_refused", x.commands_refused);
  v("safe_commands", x.safe_commands);
  v("late_commands", x.late_commands);
  v("time_ns", x.time_ns);
}

}  // namespace lss
