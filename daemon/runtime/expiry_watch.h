#pragma once

// Says when the expiry of a certificate is to be reported: once a day from 30 days before, and when
// it has expired. Time is data.

#include <cstdint>
#include <optional>

namespace lss {

class ExpiryWatch {
 public:
  static constexpr std::int64_t kDay_s = 86'400, kSoon_s = 30 * kDay_s;

  // Wall clock; INT64_MAX: nothing expires.
  explicit ExpiryWatch(std::int64_t not_after_utc_s = INT64_MAX) noexcept
      : not_after_utc_s_(not_after_utc_s) {}

  // Seconds until it expires, below 0: since then. Nothing: not to be reported now.
  std::optional<std::int64_t> look(std::int64_t utc_s) noexcept {
    if (utc_s <= not_after_utc_s_ - kSoon_s) return {};
    const std::int64_t left_s = not_after_utc_s_ - utc_s;
    if (told_utc_s_) {
      const std::int64_t since_s = utc_s - *told_utc_s_;  // below 0: the clock was set back
      const bool expired = left_s < 0 && *told_utc_s_ <= not_after_utc_s_;
      if (!expired && since_s < kDay_s && since_s > -kDay_s) return {};
    }
    told_utc_s_ = utc_s;
    return left_s;
  }

 private:
  std::int64_t not_after_utc_s_;
  std::optional<std::int64_t> told_utc_s_;
};

}  // namespace lss
