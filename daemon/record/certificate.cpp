#include "daemon/record/certificate.h"

#include <fmt/format.h>
#include <sys/utsname.h>
#include <toml++/toml.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/config/document.h"
#include "daemon/record/files.h"
#include "daemon/record/recording.h"

namespace lss::record {
namespace {

// x86 names the model of each CPU, a board with a device tree its own.
std::string machine() {
  std::ifstream cpus("/proc/cpuinfo");
  for (std::string line; std::getline(cpus, line);) {
    if (const auto colon = line.find(": "); line.starts_with("model name") && colon != line.npos)
      return line.substr(colon + 2);
  }
  std::string model;
  std::ifstream board("/proc/device-tree/model");
  std::getline(board, model, '\0');
  return model.empty() ? "unknown" : model;
}

std::string kernel() {
  utsname name{};
  ::uname(&name);
  return fmt::format("{} {} {} {}", name.sysname, name.release, name.version, name.machine);
}

// Independent of comments, blanks and the order of the keys.
std::string configuration(const std::string& text) {
  toml::table values = toml::parse(text);
  values.erase("timing");
  std::ostringstream out;
  out << toml::json_formatter(values);
  const std::string all = out.str();
  return fmt::format("{:08x}",
                     crc32c({reinterpret_cast<const std::uint8_t*>(all.data()), all.size()}));
}

// 0: no positive time is there.
TimeNs time_of(const nlohmann::ordered_json& json, const char* name) {
  const auto found = json.find(name);
  if (found == json.end() || !found->is_object()) return 0;
  const auto us = found->find("us");
  constexpr double kMost_us = 1e6;  // the longest period
  if (us == found->end() || !us->is_number()) return 0;
  const double value = us->get<double>();
  return value > 0 && value <= kMost_us ? std::llround(value * kMicrosecond) : 0;
}

}  // namespace

CertifiedOn certified_here(const std::string& version, const std::string& config) {
  return {machine(), kernel(), version, configuration(config)};
}

tl::expected<Certificate, std::string> read_certificate(const std::filesystem::path& file) {
  const auto refused = [&](const std::string& why) {
    return tl::unexpected(fmt::format("{}: {}", file.string(), config::one_line(why)));
  };
  std::error_code none;
  std::ifstream stream(file, std::ios::binary);
  if (!stream || !std::filesystem::is_regular_file(file, none))
    return refused("there is no such file, or it may not be read");
  constexpr std::streamsize kMost = 100'000;
  std::string text(kMost, '\0');
  stream.read(text.data(), kMost);
  text.resize(static_cast<std::size_t>(stream.gcount()));
  const nlohmann::ordered_json json = parse_json(text);
  Certificate certificate;
  const auto get = [&](const char* name, std::string& to) {
    const auto found = json.find(name);
    if (found == json.end() || !found->is_string()) return false;
    to = found->get<std::string>();
    return true;
  };
  if (!json.is_object() || !get("machine", certificate.on.machine) ||
      !get("kernel", certificate.on.kernel) || !get("version", certificate.on.version) ||
      !get("configuration", certificate.on.configuration)) {
    return refused("no timing certificate");
  }
  certificate.ready_ns = time_of(json, "ready");
  certificate.release_ns = time_of(json, "release");
  if (certificate.ready_ns == 0 || certificate.release_ns == 0)
    return refused("ready.us and release.us must be positive, at most a second");
  return certificate;
}

std::string not_valid(const CertifiedOn& made, const CertifiedOn& here) {
  std::string text;
  const auto compare = [&](const char* what, const std::string& then, const std::string& now) {
    if (then == now) return;
    text += fmt::format("{}the {} was \"{}\" and is \"{}\"", text.empty() ? "" : "; ", what,
                        config::one_line(then), now);
  };
  compare("machine", made.machine, here.machine);
  compare("kernel", made.kernel, here.kernel);
  compare("version of lssd", made.version, here.version);
  compare("configuration", made.configuration, here.configuration);
  return text;
}

}  // namespace lss::record
