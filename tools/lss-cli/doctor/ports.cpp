// The ports of the configuration: does it exist, may it be opened, which process uses it.

#include <fmt/format.h>
#include <grp.h>
#include <pwd.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <system_error>

#include "daemon/config/syntax.h"
#include "tools/lss-cli/doctor/checks.h"

namespace lss::cli::doctor {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSimulated = "sim:";

// Of a user or a group; its number when it has none.
template <class Entry, class Id>
std::string name_of(Id id, int (*get)(Id, Entry*, char*, std::size_t, Entry**),
                    char* Entry::*name) {
  Entry entry{};
  Entry* found = nullptr;
  std::array<char, 4096> buffer{};
  get(id, &entry, buffer.data(), buffer.size(), &found);
  return found != nullptr ? found->*name : std::to_string(id);
}
std::string group_name(gid_t gid) { return name_of(gid, ::getgrgid_r, &group::gr_name); }
std::string user_name(uid_t uid) { return name_of(uid, ::getpwuid_r, &passwd::pw_name); }

// As systemd/lssd@.service runs it: user and group lss, and dialout.
bool unit_may_open(const struct stat& file) {
  const mode_t others = S_IROTH | S_IWOTH, group = S_IRGRP | S_IWGRP;
  const std::string name = group_name(file.st_gid);
  return (file.st_mode & others) == others ||
         ((file.st_mode & group) == group && (name == "dialout" || name == "lss")) ||
         user_name(file.st_uid) == "lss";
}

std::string rights(const struct stat& file) {
  return fmt::format("{}:{} {:o}", user_name(file.st_uid), group_name(file.st_gid),
                     file.st_mode & 0777U);
}

std::string udev_rule(const fs::path& device) {
  return fmt::format(
      "a udev rule: KERNEL==\"{}\", SUBSYSTEM==\"tty\", GROUP=\"dialout\", MODE=\"0660\"",
      device.filename().string());
}

Finding problem(const std::string& name, std::string found, std::string meaning,
                std::string remedy) {
  return {name, Result::problem, std::move(found), std::move(meaning), std::move(remedy)};
}

Finding absent(const std::string& name, const fs::path& path, const config::Config& config,
               const System& system, bool simulated) {
  return problem(
      name, fmt::format("{} is not there", path.string()),
      "lssd starts without it, with the fault port_absent, and opens it by itself when it comes",
      simulated ? fmt::format("start lss-sim {} --dir {}, or name its folder with --run-dir",
                              config.vehicle, system.run_dir.string())
                : "plug it in, or name another in [[port]] path: ls -l /dev/serial/by-id "
                  "/dev/ttyS* /dev/ttyUSB*");
}

// Another process has it open. The simulator keeps both ends of its pseudo-terminals open.
Finding held(const std::string& name, const std::string& where,
             const std::vector<Process>& holders) {
  Finding finding{.name = name,
                  .found = fmt::format("{}, open in {}", where, spoken(holders)),
                  .meaning = "the daemon has it"};
  if (holders.size() == 1 && holders.front().name == "lssd") return finding;
  return problem(name, finding.found,
                 "bytes go to one of several readers by chance, and lssd refuses a port that "
                 "another program has locked",
                 "stop what does not belong there: one lssd for each port, and nothing else");
}

Finding refused(const System& system, const std::string& name, const fs::path& device,
                const SerialAnswer& answer, const struct stat& file) {
  const std::string found =
      fmt::format("{} does not open: {}", device.string(), std::strerror(answer.error));
  if (answer.error == EBUSY) {
    const std::vector<Process> daemons = processes_named(system, "lssd");
    if (!daemons.empty()) {
      return {name, Result::note, found,
              fmt::format("most likely {} has it; only root can see that", spoken(daemons))};
    }
    return problem(name, found, "a program that only root can see has it for itself",
                   fmt::format("sudo fuser -v {} shows who; stop it", device.string()));
  }
  if (answer.error != EACCES && answer.error != EPERM) {
    return problem(name, found, "lssd cannot open it either",
                   "dmesg says what is wrong with the device");
  }
  const std::string owner = fmt::format("it belongs to {}", rights(file));
  if (answer.pseudo) {
    return problem(name, found, owner, "start lss-sim and lssd as the same user");
  }
  if (unit_may_open(file)) {
    return {name, Result::note, found, owner + ": the unit lssd@ may open it, this user may not",
            "usermod -aG dialout USER, and log in again, to run lssd by hand"};
  }
  return problem(name, found, owner + ": neither this user nor the unit lssd@ may open it",
                 udev_rule(device));
}

std::string latency(const SerialAnswer& answer) {
  if (answer.pseudo) return "low latency does not apply to a pseudo-terminal";
  if (!answer.low_latency) {
    return "its driver has no low-latency switch: a USB adapter may delay bytes by 16 ms";
  }
  return *answer.low_latency ? "low latency is on" : "low latency is off until lssd switches it on";
}

Finding check_serial(const System& system, const std::string& name, const fs::path& path,
                     const config::Config& config, bool simulated) {
  struct stat file {};
  std::error_code error;
  const fs::path device = fs::canonical(path, error);
  if (error || ::stat(device.c_str(), &file) != 0) {
    return absent(name, path, config, system, simulated);
  }
  const std::string where =
      device == path ? path.string() : fmt::format("{} ({})", path.string(), device.string());
  std::vector<Process> holders = processes_with(system, device);
  if (simulated) std::erase_if(holders, [](const Process& p) { return p.name == "lss-sim"; });
  if (!holders.empty()) return held(name, where, holders);

  const SerialAnswer answer = system.ask_serial(device);
  if (answer.error != 0) return refused(system, name, device, answer, file);
  if (!answer.terminal) {
    return problem(name, where + " is no terminal", "lssd refuses to start on it",
                   "name a serial port in [[port]] path");
  }
  Finding finding{.name = name,
                  .found = fmt::format("{} is free; {}", where, latency(answer)),
                  .meaning = "lssd can open it"};
  if (answer.pseudo) return finding;
  if (!unit_may_open(file)) {
    finding.result = Result::warning;
    finding.meaning = fmt::format(
        "this user may open it, but the unit lssd@ may not: it belongs to {}", rights(file));
    finding.remedy = udev_rule(device);
  } else if (!answer.low_latency) {
    finding.result = Result::note;
    finding.meaning = "lssd can open it; replies may come in late";
  }
  return finding;
}

// Whether a socket of this machine is bound to the port.
bool udp_bound(const System& system, unsigned port) {
  std::istringstream lines(read_text(system.proc / "net/udp").value_or(""));
  std::string line;
  std::getline(lines, line);  // the heading
  while (std::getline(lines, line)) {
    std::istringstream columns(line);
    std::string slot, address;
    columns >> slot >> address;  // "0: 0100007F:4E20"
    const std::size_t colon = address.find(':');
    if (colon != std::string::npos && std::stoul(address.substr(colon + 1), nullptr, 16) == port)
      return true;
  }
  return false;
}

Finding check_udp(const System& system, const std::string& name, const std::string& path,
                  const config::Config& config) {
  const auto udp = config::udp_address(path);
  if (!udp) {
    return problem(name, path + " is no address", "lssd refuses the configuration",
                   "write udp://127.0.0.1:PORT");
  }
  Finding finding{.name = name, .found = path};
  if (!udp->host.starts_with("127.")) {
    finding.result = Result::note;
    finding.meaning =
        "CAN frames go to another machine: whether it listens cannot be seen from here";
    return finding;
  }
  if (udp_bound(system, static_cast<unsigned>(std::stoul(std::string(udp->port))))) {
    finding.found += " has a listener";
    finding.meaning = "the other end of the bus is there";
    return finding;
  }
  finding.result = Result::warning;
  finding.found += " has no listener";
  finding.meaning = "CAN frames of lssd go nowhere";
  finding.remedy = fmt::format("start the other end: lss-sim {}, or cannelloni", config.vehicle);
  return finding;
}

}  // namespace

Finding check_port(const System& system, const config::Config& config, const config::Port& port) {
  const std::string name = "port/" + port.name;
  if (port.path.starts_with("udp://")) return check_udp(system, name, port.path, config);
  if (config::is_can(port.path)) {
    Finding finding = check_can(system, port.path);
    finding.name = name;
    return finding;
  }
  const bool simulated = port.path.starts_with(kSimulated);
  const fs::path path =
      simulated ? system.run_dir / port.path.substr(std::strlen(kSimulated)) : fs::path(port.path);
  if (!path.is_absolute() && !simulated) {
    return problem(name, fmt::format("\"{}\" is no port", port.path),
                   "lssd refuses the configuration",
                   "write sim:NAME, /dev/DEVICE, canN or udp://127.0.0.1:PORT");
  }
  return check_serial(system, name, path, config, simulated);
}

}  // namespace lss::cli::doctor
