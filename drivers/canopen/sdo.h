#pragma once

// SDO client of one node: expedited transfers of 1 to 4 bytes, one at a time. Frames and time in
// and out; nothing allocates. docs/icd-ardito.md section 7.

#include <cstdint>

#include "drivers/can/frame.h"

namespace lss::canopen {

inline constexpr TimeNs kNever = INT64_MAX;

// One object of a node and a value for it.
struct Entry {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t size = 0;  // bytes, 1 to 4
  std::uint32_t value = 0;
  bool optional = false;  // a node without this object is as good

  bool operator==(const Entry&) const = default;
};

// Our own abort: the node did not answer. The same number as in CiA 301.
inline constexpr std::uint32_t kAbortTimeout = 0x0504'0000;
inline constexpr std::uint32_t kAbortBadCommand = 0x0504'0001;
// Of a node: it does not have the object, or the sub-index.
inline constexpr std::uint32_t kAbortNoObject = 0x0602'0000, kAbortNoSub = 0x0609'0011;

struct SdoCounters {
  std::uint64_t requests = 0;  // with repetitions
  std::uint64_t repeats = 0;
  std::uint64_t unexpected = 0;  // answers without a request, late ones too
  std::uint64_t aborts = 0;      // by the node, and by time-out
};

class SdoClient {
 public:
  enum class Result : std::uint8_t {
    idle,     // no request
    pending,  // no answer yet
    done,     // written, or read: value()
    aborted,  // abort_code() says why
  };

  SdoClient() = default;
  SdoClient(std::uint8_t node, TimeNs timeout_ns, int attempts) noexcept
      : node_(node), timeout_ns_(timeout_ns), attempts_(attempts) {}

  void write(const Entry& entry) noexcept { ask(entry, true); }
  void read(std::uint16_t index, std::uint8_t sub) noexcept { ask({index, sub, 0, 0}, false); }
  void cancel() noexcept {
    result_ = Result::idle;
    tell_ = false;
  }

  void receive(const CanFrame& frame) noexcept;  // an SDO answer of this node
  // True: `frame` is to be sent now. Ends the transfer when no answer came to the last attempt.
  bool transmit(TimeNs now, CanFrame& frame) noexcept;
  TimeNs next_wake() const noexcept;  // INT64_MAX: never, INT64_MIN: at once

  // False: transmit() has nothing to do.
  bool busy() const noexcept { return tell_ || result_ == Result::pending; }
  Result result() const noexcept { return result_; }
  const Entry& entry() const noexcept { return entry_; }  // the last one asked for
  std::uint32_t value() const noexcept { return entry_.value; }
  std::uint32_t abort_code() const noexcept { return abort_code_; }
  const SdoCounters& counters() const noexcept { return counters_; }

 private:
  void ask(const Entry& entry, bool writes) noexcept;
  void abort(std::uint32_t code) noexcept;

  std::uint8_t node_ = 0;
  TimeNs timeout_ns_ = 0;
  int attempts_ = 0;
  Entry entry_{};
  bool writes_ = false;
  Result result_ = Result::idle;
  int sent_ = 0;            // times
  TimeNs deadline_ns_ = 0;  // of the attempt under way
  std::uint32_t abort_code_ = 0;
  bool tell_ = false;  // report our abort to the node
  SdoCounters counters_{};
};

}  // namespace lss::canopen
