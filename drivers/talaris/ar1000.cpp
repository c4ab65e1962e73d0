#include "drivers/talaris/ar1000.h"

#include <algorithm>
#include <charconv>
#include <string_view>

namespace lss::talaris {
namespace {

constexpr std::uint8_t kEscape = 0x1B;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::size_t digits(std::string_view text) {
  std::size_t n = 0;
  while (n < text.size() && is_digit(text[n])) ++n;
  return n;
}

std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

// [-]digits[.digits][ blanks digits]
bool parse_range(std::string_view text, double& range_m) {
  const bool negative = text.starts_with('-');
  const std::string_view number = text.substr(negative ? 1 : 0);
  std::size_t end = digits(number);
  if (end == 0) return false;
  if (end < number.size() && number[end] == '.') end += 1 + digits(number.substr(end + 1));
  const std::string_view rest = number.substr(end);
  const std::string_view signal = without_blanks(rest);
  if (digits(signal) != signal.size()) return false;
  if (!signal.empty() && rest.front() != ' ') return false;
  const auto parsed = std::from_chars(number.data(), number.data() + end, range_m);
  if (parsed.ec != std::errc{}) return false;
  if (negative) range_m = -range_m;
  return true;
}

bool parse_error(std::string_view text, std::uint8_t& code) {
  if (!text.starts_with('E')) return false;
  const auto [end, error] = std::from_chars(text.data() + 1, text.data() + text.size(), code);
  return error == std::errc{} && end == text.data() + text.size() && code != 0 &&
         code != Range::kOutOfRange;
}

}  // namespace

Ar1000::Ar1000(const Ar1000Parameters& parameters) noexcept
    : SensorLine({parameters.baud, SerialFormat::Parity::none, 1, false}), parameters_(parameters) {
  restart(0);
}

void Ar1000::restart(TimeNs now) noexcept {
  clear();
  size_ = 0;
  spoilt_ = false;
  whole_ = false;
  step_ = Step::stop;
  step_ns_ = now;
}

void Ar1000::receive(std::span<const LineByte> bytes, TimeNs now) noexcept {
  status_.counters.bytes += bytes.size();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const LineByte& byte = bytes[i];
    if (byte.value == '\n' && !byte.bad) {
      if (whole_) {
        alive_ns_ = std::max(alive_ns_, now);
        end_line();
      } else {
        status_.counters.skipped += size_ + 1;
      }
      whole_ = true;
      size_ = 0;
      spoilt_ = marked_ = false;
      continue;
    }
    if (size_ == 0 && !spoilt_) first_ns_ = arrival_ns(now, i, bytes.size());
    marked_ = marked_ || byte.bad;
    spoilt_ = spoilt_ || size_ == line_.size();
    if (!spoilt_) line_[size_++] = static_cast<char>(byte.value);
  }
}

// CR LF end a line; the CR is still in the buffer.
void Ar1000::end_line() noexcept {
  std::string_view text(line_.data(), size_);
  if (marked_) {
    ++status_.counters.parity;
    return;
  }
  if (spoilt_ || !text.ends_with('\r')) {
    ++status_.counters.bad_check;
    return;
  }
  text = without_blanks(text.substr(0, text.size() - 1));
  Range range;
  if (parse_error(text, range.error)) {
    ++status_.counters.said_errors;
  } else if (!parse_range(text, range.range_m)) {
    ++status_.counters.bad_check;
    return;
  } else if (!(range.range_m >= parameters_.nearest_m && range.range_m <= parameters_.farthest_m)) {
    ++status_.counters.out_of_range;
    range = {0, Range::kOutOfRange};
  }
  ++status_.counters.packets;
  status_.heard_ns = std::max(first_ns_ - parameters_.latency_ns, status_.heard_ns + 1);
  keep({status_.heard_ns, range});
}

std::span<const std::uint8_t> Ar1000::transmit(TimeNs now) noexcept {
  if (step_ == Step::listen && now - alive_ns_ >= parameters_.silent_after_ns) {
    ++status_.counters.restarts;
    step_ = Step::stop;
    step_ns_ = now;
  }
  if (step_ == Step::listen || now < step_ns_) return {};
  ++status_.counters.commands;
  if (step_ == Step::stop) {
    step_ = Step::start;
    step_ns_ = now + parameters_.stop_ns;
    out_[0] = kEscape;
    return std::span(out_).first(1);
  }
  step_ = Step::listen;
  alive_ns_ = now;
  std::size_t size = 0;
  for (const char c : parameters_.start_command) {
    if (c == '\0') break;
    out_[size++] = static_cast<std::uint8_t>(c);
  }
  out_[size++] = '\r';
  return std::span(out_).first(size);
}

TimeNs Ar1000::next_wake() const noexcept {
  return step_ == Step::listen ? alive_ns_ + parameters_.silent_after_ns : step_ns_;
}

}  // namespace lss::talaris
