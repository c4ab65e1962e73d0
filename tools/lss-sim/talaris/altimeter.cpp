#include "tools/lss-sim/talaris/altimeter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace lss::sim::talaris {
namespace {

constexpr std::uint8_t kEscape = 0x1B, kReturn = 0x0D;
constexpr double kWhite_s = 0.1;    // DW: ten a second on a white target
constexpr double kNormal_s = 0.16;  // DT, DS: as long as the target needs
constexpr double kBegin_s = 0.2;    // from the command to the first reading
constexpr int kWeakSignal = 15;
constexpr std::size_t kLongest = 24;  // command

}  // namespace

void Altimeter::step(std::optional<double> distance_m) {
  const std::lock_guard lock(mutex_);
  before_.push_back(distance_m);
  distance_m_ = before_.front();
  if (before_.size() > static_cast<std::size_t>(std::lround(options_.latency_s * 1e3)))
    before_.pop_front();
  if (period_s_ <= 0) return;
  left_s_ -= 1e-3;
  if (left_s_ > 0) return;
  left_s_ += period_s_ + std::uniform_real_distribution(-1.0, 1.0)(random_) * options_.jitter_s;
  say();
}

void Altimeter::say() {
  const double noise =
      options_.noise_m > 0 ? std::normal_distribution<double>(0, options_.noise_m)(random_) : 0;
  if (faults_.silent) return;
  std::string line;
  if (faults_.stuck && !said_.empty()) {
    line = said_;
  } else if (faults_.garbage) {
    std::uniform_int_distribution<int> any(0x21, 0x7E);
    for (int i = 0; i < 7; ++i) line.push_back(static_cast<char>(any(random_)));
  } else if (faults_.error) {
    line = fmt::format("E{:02d}", *faults_.error);
  } else if (const double seen_m = distance_m_.value_or(-1);
             !faults_.out_of_range && seen_m >= options_.min_m && seen_m <= options_.max_m) {
    line = fmt::format(
        "{:07.3f}", std::clamp(seen_m + noise + options_.bias_m + faults_.offset_m, 0.0, 999.999));
    said_ = line;
  } else {
    line = fmt::format("E{:02d}", kWeakSignal);
  }
  line += "\r\n";
  queue({reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
}

std::span<const std::uint8_t> Altimeter::receive(std::uint8_t character, TimeNs) {
  const std::lock_guard lock(mutex_);
  if (character == kEscape) {
    period_s_ = 0;
    command_.clear();
  } else if (character == kReturn) {
    obey();
    command_.clear();
  } else if (command_.size() < kLongest) {
    command_.push_back(static_cast<char>(std::toupper(character)));
  }
  return {};
}

void Altimeter::obey() {
  if (command_ == "DW") {
    period_s_ = kWhite_s;
  } else if (command_ == "DT" || command_ == "DS") {
    period_s_ = kNormal_s;
  } else if (command_ == "DM") {
    say();
    return;
  } else {
    return;
  }
  left_s_ = kBegin_s;
}

bool Altimeter::measuring() const {
  const std::lock_guard lock(mutex_);
  return period_s_ > 0;
}

}  // namespace lss::sim::talaris
