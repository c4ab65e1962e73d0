#pragma once

// The armour for what a leg module reports: range (docs/icd-zebro.md section 5), rate between two
// statuses, agreement with the order within its ramp, and with the Hall sensor. One per module.
// Frame thread; time is data; nothing allocates. Limits: docs/icd-zebro.md section 9.

#include <cstdint>

#include "drivers/zebro/leg_bus.h"
#include "idl/zebro/codes.h"

namespace lss::zebro {

// Of frames. With longer ones every status is too old to show that a leg stands still.
inline constexpr TimeNs kLongestPeriod = 50 * kMillisecond;

class ReportCheck {
 public:
  enum class Finding : std::uint8_t {
    none,
    impossible,  // values out of their range, or reserved flags
    jumps,       // further from one status to the next than the module can turn
    still,       // its position does not follow the order
    slips,       // at its Hall sensor it was elsewhere than it counted
  };

  // How much of a report may be used.
  enum class Use : std::uint8_t { nothing, flags, all };

  // A status or a health page that arrived at `time`. `leg`: its Hall sensor is at half a turn.
  Use take(const Status& status, TimeNs time, bool leg) noexcept;
  Use take(const Health& health, TimeNs time) noexcept;

  // Once per frame, of a leg with the order that went out last.
  void follow(const ModuleOrder& order, const Status& status, TimeNs status_ns,
              TimeNs now) noexcept;

  // Found within the last second.
  Finding finding(TimeNs now) const noexcept {
    return finding_ != Finding::none && now - found_ns_ <= kLasts ? finding_ : Finding::none;
  }
  // What it was, and what is allowed; positions in degrees.
  double measured() const noexcept { return measured_; }
  double limit() const noexcept { return limit_; }

  // What decides and is no angle, for a key of the state (tools/lss-lc).
  template <class V>
  void times(V&& v) const {
    v(found_ns_, strange_ns_, window_ns_, still_ns_, refused_);
  }

 private:
  static constexpr TimeNs kLasts = kSecond;

  Use refuse(Finding finding, double measured, double limit, TimeNs time, Use use) noexcept;
  void find(Finding finding, double measured, double limit, TimeNs time) noexcept;
  void begin_order(const ModuleOrder& order, const Status& status, TimeNs now) noexcept;

  // Statuses.
  TimeNs last_ns_ = 0;  // of the last one in use; 0: none
  double last_rad_ = 0;
  std::uint16_t last_flags_ = 0;
  TimeNs strange_ns_ = 0;  // of the last one that jumped; 0: none since
  double strange_rad_ = 0;
  int refused_ = 0;  // since window_ns_
  TimeNs window_ns_ = 0;

  // The order under way.
  std::uint32_t serial_ = 0;
  bool under_way_ = false;
  double way_rad_ = 0;  // signed
  TimeNs begun_ns_ = 0, due_ns_ = 0;
  double seen_rad_ = 0;       // in the frame before
  double travelled_rad_ = 0;  // signed
  double base_expected_rad_ = 0, base_travelled_rad_ = 0;
  TimeNs still_ns_ = 0;  // since when it does not move; 0: it does

  Finding finding_ = Finding::none;
  TimeNs found_ns_ = 0;
  double measured_ = 0, limit_ = 0;
};

// How late replies come, from the uptime that the module reports: a reply has no number, so a late
// one looks like the answer to a newer request (docs/icd-zebro.md section 9).
class Lateness {
 public:
  void heard(TimeNs time, double uptime_s) noexcept;
  TimeNs late_ns() const noexcept { return late_ns_; }

 private:
  TimeNs booted_ns_ = 0;  // by the replies that came soonest; 0: unknown
  TimeNs heard_ns_ = 0, up_ns_ = 0, late_ns_ = 0;
};

// The fault of a finding.
FaultId fault_of(ReportCheck::Finding finding) noexcept;

}  // namespace lss::zebro
