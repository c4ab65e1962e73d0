#pragma once

// Counts what repeats, so that no flood of one event hides another. The first occurrence of an
// event is reported at once. More of the same id and subject, each less than kSeries after the one
// before, are one series: it is reported again after a second, then after 2, 4, ... 60 s at most
// while it goes on, with its count and the times of its first and newest occurrence, and once more
// when its last occurrence is not reported yet. Any one thread; time is data; bounded, no
// allocation.

#include <algorithm>
#include <array>
#include <cstdint>

#include "daemon/cycle/messages.h"

namespace lss {

// Steps of a course (state, mode, phase, results of commands) and fatal faults, each of which needs
// a command before the next, are reported one by one; so are a drive's drop-outs, of which the
// fourth within ten seconds is a fault.
constexpr bool is_counted(const EventRecord& event) noexcept {
  switch (static_cast<EventId>(event.id)) {
    case EventId::fault_cleared:
    case EventId::port_opened:
    case EventId::node_configured: return true;  // the other half of what is counted
    case EventId::drive_dropped_out: return false;
    default: return event.severity == Severity::warning || event.severity == Severity::error;
  }
}

class EventSeries {
 public:
  static constexpr TimeNs kSeries = 60 * kSecond;
  static constexpr TimeNs kFirstWait = kSecond, kLongestWait = 60 * kSecond;
  static constexpr std::size_t kMost = 64;  // at a time; one more replaces the oldest

  // report(event): now.
  template <class Report>
  void add(EventRecord event, Report&& report) noexcept {
    event.first_ns = event.time_ns;
    event.count = 1;
    if (!is_counted(event)) return report(event);
    Series& s = find(event);
    const bool same = s.count != 0 && is_same(s, event);
    if (same && event.time_ns - s.newest_ns < kSeries) {
      ++s.count;
      s.newest_ns = event.time_ns;
      s.argument = event.argument;
      s.unreported = 1;
      return;
    }
    if (s.unreported != 0) report(record(s));
    s = {.newest_ns = event.time_ns,
         .first_ns = event.time_ns,
         .due_ns = event.time_ns + kFirstWait,
         .wait_ns = kFirstWait,
         .argument = event.argument,
         .count = 1,
         .id = event.id,
         .subject = event.subject,
         .severity = static_cast<std::uint32_t>(event.severity)};
    report(event);
  }

  // In every frame: series that are due.
  template <class Report>
  void report_due(TimeNs now, Report&& report) noexcept {
    for (Series& s : series_) {
      if (s.unreported == 0 || now < s.due_ns) continue;
      s.wait_ns = std::min(2 * s.wait_ns, kLongestWait);
      s.due_ns = now + s.wait_ns;
      s.unreported = 0;
      report(record(s));
    }
  }

  // Everything that is not reported yet, at the end.
  template <class Report>
  void report_all(Report&& report) noexcept {
    for (Series& s : series_) {
      if (s.unreported != 0) report(record(s));
      s.unreported = 0;
    }
  }

  template <class V>
  void keep(V& v) {
    v(series_);
  }

 private:
  struct Series {  // without padding: its bytes are recorded
    TimeNs newest_ns = 0, first_ns = 0, due_ns = 0, wait_ns = 0;
    std::array<double, 4> argument{};
    std::uint32_t count = 0, unreported = 0;  // count 0: unused
    std::uint16_t id = 0, subject = 0;
    std::uint32_t severity = 0;
  };

  static bool is_same(const Series& s, const EventRecord& event) noexcept {
    if (s.id != event.id || s.subject != event.subject) return false;
    switch (static_cast<EventId>(event.id)) {
      case EventId::command_rejected:  // of the same command, for the same reason
        return s.argument[0] == event.argument[0] && s.argument[1] == event.argument[1];
      case EventId::fault_cleared:      // the same fault
      case EventId::emergency_message:  // the same code
        return s.argument[0] == event.argument[0];
      default: return true;
    }
  }

  // Its series, else an unused one, else the one whose newest occurrence is the oldest.
  Series& find(const EventRecord& event) noexcept {
    Series* oldest = &series_.front();
    for (Series& s : series_) {
      if (s.count != 0 && is_same(s, event)) return s;
      if (s.newest_ns < oldest->newest_ns || s.count == 0) oldest = &s;
    }
    return *oldest;
  }

  static EventRecord record(const Series& s) noexcept {
    return {.time_ns = s.newest_ns,
            .severity = static_cast<Severity>(s.severity),
            .id = s.id,
            .subject = s.subject,
            .count = s.count,
            .first_ns = s.first_ns,
            .argument = s.argument};
  }

  std::array<Series, kMost> series_{};
};

}  // namespace lss
