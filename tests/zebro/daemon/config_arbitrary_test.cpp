// The boundary of the configuration: with any bytes in a file, lssd either starts from values that
// are all within their limits, or reports the errors in lines of FILE:LINE:COLUMN.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "daemon/vehicles/zebro/config.h"

namespace lss::zebro {
namespace {

std::vector<std::string> example() {
  std::ifstream in(LSS_CONFIG);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

void expect_within_limits(const config::Config& config, const Parameters& p) {
  RC_ASSERT(config.period_ns > 0);
  RC_ASSERT(config.offset_ns > 0 && config.offset_ns <= config.period_ns);
  RC_ASSERT(config.max_consecutive_overruns > 0);
  RC_ASSERT(!config.vehicle_id.empty() && config.vehicle_id.size() < 16);
  RC_ASSERT(config.lease_min_ms > 0 && config.lease_min_ms <= config.lease_max_ms);
  RC_ASSERT(!config.ports.empty());
  for (const config::Thread& thread : config.threads)
    RC_ASSERT(thread.priority >= 0 && thread.priority <= 99);
  RC_ASSERT(gnc::zebro::check(p.locomotion) == nullptr);
  RC_ASSERT(std::isfinite(p.locomotion.swing_limit_rad_s) && p.locomotion.swing_limit_rad_s > 0);
  RC_ASSERT(p.current_limit_A > 0 && p.current_limit_A <= 1.7);
  RC_ASSERT(p.module_silent_ns > 0 && p.module_silent_ns < 8 * kSecond);
  RC_ASSERT(p.bus.resend_limit >= 0);
  const std::set<int> addresses(p.bus.address.begin(), p.bus.address.end());
  RC_ASSERT(addresses.size() == p.bus.address.size());
  RC_ASSERT(*addresses.begin() >= 1 && *addresses.rbegin() <= 127);
}

// True when it was taken.
bool taken_or_told(const std::string& text) {
  std::string file = testing::TempDir() + "lss-arbitrary-XXXXXX";
  const int fd = ::mkstemp(file.data());
  RC_ASSERT(fd >= 0);
  RC_ASSERT(::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  ::close(fd);
  Parameters parameters;
  const auto config = config::load(file, {"zebro"}, [&](const std::string&, config::Section& s) {
    parameters = read_parameters(s);
  });
  ::unlink(file.c_str());
  if (config) {
    expect_within_limits(*config, parameters);
    return true;
  }
  RC_ASSERT(!config.error().empty());
  std::istringstream lines(config.error());
  for (std::string line; std::getline(lines, line);) RC_ASSERT(line.rfind(file, 0) == 0u);
  return false;
}

RC_GTEST_PROP(ArbitraryConfig, NoBytesMakeAConfigurationByThemselves,
              (const std::vector<unsigned char>& bytes)) {
  RC_ASSERT(!taken_or_told(std::string(bytes.begin(), bytes.end())));
}

RC_GTEST_PROP(ArbitraryConfig, TheExampleWithBrokenBytesIsWithinLimitsOrRefused, ()) {
  std::string text = joined(example());
  const int changes = *rc::gen::inRange(1, 6);
  for (int i = 0; i < changes; ++i) {
    const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
    switch (*rc::gen::inRange(0, 3)) {
      case 0: text[at] = *rc::gen::arbitrary<char>(); break;
      case 1: text.erase(at, *rc::gen::inRange<std::size_t>(1, 80)); break;
      default: text.insert(at, 1, *rc::gen::arbitrary<char>());
    }
  }
  RC_CLASSIFY(taken_or_told(text), "taken");
}

RC_GTEST_PROP(ArbitraryConfig, AnyValueInThePlaceOfAnyOtherIsWithinLimitsOrRefused, ()) {
  std::vector<std::string> lines = example();
  std::vector<std::size_t> keys;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::size_t equals = lines[i].find('=');
    if (equals != std::string::npos && lines[i][0] != '#') keys.push_back(i);
  }
  std::string& line = lines[*rc::gen::elementOf(keys)];
  const double old = std::strtod(line.c_str() + line.find('=') + 1, nullptr);
  line.resize(line.find('=') + 1);
  line +=
      " " +
      *rc::gen::oneOf(
          rc::gen::element<std::string>(
              "nan", "inf", "-inf", "true", "\"\"", "\"0\"", "[]", "{}", "[[]]", "1e308", "-1e-308",
              "9223372036854775807", "-9223372036854775808", "99999999999999999999", "1979-05-27",
              "[1, 2, 3, 4, 5, 6, 7]", "[1, 1, 1, 1, 1, 1, 1]", "\"/\"", "\"sim:\"", "\"udp://\""),
          rc::gen::map(rc::gen::inRange(-30, 30),
                       [old](int n) { return fmt::format("{:.6g}", old * n / 10); }),
          rc::gen::map(rc::gen::inRange(-30, 30),
                       [old](int n) { return fmt::format("{:.0f}", old * n / 10); }),
          rc::gen::map(rc::gen::arbitrary<int>(), [](int n) { return std::to_string(n); }),
          rc::gen::map(rc::gen::arbitrary<double>(), [](double x) { return std::to_string(x); }));
  RC_CLASSIFY(taken_or_told(joined(lines)), "taken");
}

RC_GTEST_PROP(ArbitraryConfig, LinesMayBeMissingOrDouble, ()) {
  std::vector<std::string> lines = example();
  const auto at = *rc::gen::inRange<std::size_t>(0, lines.size());
  if (*rc::gen::arbitrary<bool>()) {
    lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(at));
  } else {
    lines.insert(lines.begin() +
                     static_cast<std::ptrdiff_t>(*rc::gen::inRange<std::size_t>(0, lines.size())),
                 lines[at]);
  }
  RC_CLASSIFY(taken_or_told(joined(lines)), "taken");
}

}  // namespace
}  // namespace lss::zebro
