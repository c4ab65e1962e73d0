#pragma once

// The machine as the checks of lss-cli doctor see it: the places of its files, and the results of
// system calls. Tests replace both by prepared folders and results. Main thread.

#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "idl/roudi.h"
#include "tools/lss-cli/doctor/probes.h"

namespace lss::cli::doctor {

struct System {
  std::filesystem::path proc = "/proc", sys = "/sys";
  std::filesystem::path configurations = "/etc/lss";
  std::filesystem::path run_dir = "/run/lss", state_dir = "/var/lib/lss", shm_dir = "/dev/shm";

  std::function<int(int)> ask_fifo = doctor::ask_fifo;
  std::function<double()> clock_read_ns = doctor::clock_read_ns;
  std::function<bool()> clock_synchronised = doctor::clock_synchronised;
  std::function<std::int64_t()> utc_offset_ns = doctor::utc_offset_ns;
  std::function<SerialAnswer(const std::filesystem::path&)> ask_serial = doctor::ask_serial;
  std::function<int()> ask_can_socket = doctor::ask_can_socket;
  std::function<std::optional<CanLink>(const std::string&)> ask_can_link = doctor::ask_can_link;
  std::function<std::optional<Space>(const std::filesystem::path&)> space = doctor::space;
  std::function<std::optional<dds::RoudiIdentity>()> find_roudi = dds::find_roudi;
};

// Without blanks at the ends; empty when there is no such file, or we may not read it.
std::optional<std::string> read_text(const std::filesystem::path& file);
std::optional<std::int64_t> read_number(const std::filesystem::path& file);

// The names in a folder, sorted; none when it cannot be read.
std::vector<std::string> names_in(const std::filesystem::path& folder);

// "0-3,5" as the kernel writes lists of CPUs.
std::vector<int> parse_cpus(std::string_view list);

struct Process {
  pid_t pid = 0;
  std::string name;
};

// The processes of that name; and those that have the file open, as far as this user may see,
// without this one.
std::vector<Process> processes_named(const System& system, std::string_view name);
std::vector<Process> processes_with(const System& system, const std::filesystem::path& file);

// "lssd (pid 7), minicom (pid 9)".
std::string spoken(const std::vector<Process>& processes);

// Of this process: bit `capability` of its effective set.
bool has_capability(const System& system, int capability);
// Soft limit of this process by its name in /proc/self/limits; -1: unlimited.
std::optional<std::int64_t> limit(const System& system, std::string_view name);

}  // namespace lss::cli::doctor
