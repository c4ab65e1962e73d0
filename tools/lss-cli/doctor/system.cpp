#include "tools/lss-cli/doctor/system.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <sstream>
#include <system_error>

namespace lss::cli::doctor {
namespace {

namespace fs = std::filesystem;

template <class Number>
std::optional<Number> parse(std::string_view text, int base = 10) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// The folders of processes.
std::vector<pid_t> pids(const System& system) {
  std::vector<pid_t> list;
  for (const std::string& name : names_in(system.proc)) {
    if (const auto pid = parse<pid_t>(name)) list.push_back(*pid);
  }
  return list;
}

Process process(const System& system, pid_t pid) {
  return {pid, read_text(system.proc / std::to_string(pid) / "comm").value_or("?")};
}

}  // namespace

std::optional<std::string> read_text(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) return std::nullopt;
  // By read(), which reports what a stream's buffer throws: a process can end before its file is
  // read.
  std::string text;
  for (std::array<char, 4096> piece{}; stream;) {
    stream.read(piece.data(), piece.size());
    text.append(piece.data(), static_cast<std::size_t>(stream.gcount()));
  }
  if (stream.bad()) return std::nullopt;
  const std::size_t first = text.find_first_not_of(" \t\n");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\n") - first + 1);
}

std::optional<std::int64_t> read_number(const fs::path& file) {
  const std::optional<std::string> text = read_text(file);
  if (!text) return std::nullopt;
  if (text->starts_with("0x")) return parse<std::int64_t>(std::string_view(*text).substr(2), 16);
  return parse<std::int64_t>(*text);
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    names.push_back(entry->path().filename());
  }
  std::ranges::sort(names);
  return names;
}

std::vector<int> parse_cpus(std::string_view list) {
  std::vector<int> cpus;
  std::istringstream parts{std::string(list)};
  for (std::string part; std::getline(parts, part, ',');) {
    const std::size_t dash = part.find('-');
    const auto first = parse<int>(std::string_view(part).substr(0, dash));
    const auto last =
        dash == std::string::npos ? first : parse<int>(std::string_view(part).substr(dash + 1));
    if (!first || !last) continue;
    for (int cpu = *first; cpu <= *last; ++cpu) cpus.push_back(cpu);
  }
  return cpus;
}

std::vector<Process> processes_named(const System& system, std::string_view name) {
  std::vector<Process> found;
  for (const pid_t pid : pids(system)) {
    if (const Process candidate = process(system, pid); candidate.name == name) {
      found.push_back(candidate);
    }
  }
  return found;
}

std::vector<Process> processes_with(const System& system, const fs::path& file) {
  std::vector<Process> found;
  for (const pid_t pid : pids(system)) {
    if (pid == ::getpid()) continue;
    const fs::path folder = system.proc / std::to_string(pid) / "fd";
    const std::vector<std::string> fds = names_in(folder);
    const bool open = std::ranges::any_of(fds, [&](const std::string& fd) {
      std::error_code error;
      return fs::read_symlink(folder / fd, error) == file;
    });
    if (open) found.push_back(process(system, pid));
  }
  return found;
}

std::string spoken(const std::vector<Process>& processes) {
  std::string list;
  for (const Process& p : processes) {
    list += fmt::format("{}{} (pid {})", list.empty() ? "" : ", ", p.name, p.pid);
  }
  return list;
}

bool has_capability(const System& system, int capability) {
  std::istringstream lines(read_text(system.proc / "self/status").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("CapEff:")) continue;
    const auto bits = parse<std::uint64_t>(line.substr(line.find_first_not_of(" \t", 7)), 16);
    return bits && (*bits >> capability & 1U) != 0;
  }
  return false;
}

std::optional<std::int64_t> limit(const System& system, std::string_view name) {
  std::istringstream lines(read_text(system.proc / "self/limits").value_or(""));
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(name)) continue;
    std::istringstream columns(line.substr(name.size()));
    std::string soft;
    columns >> soft;
    if (soft == "unlimited") return -1;
    return parse<std::int64_t>(soft);
  }
  return std::nullopt;
}

}  // namespace lss::cli::doctor
