// lss-cli doctor on the ports of the configuration, on the needs of DDS, and on configurations
// themselves.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "tests/cli/doctor_machine.h"
#include "tools/lss-cli/doctor/read_config.h"
#include "tools/lss-cli/doctor/report.h"

namespace lss::cli::test {
namespace {

using namespace doctor;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

// Both ends of a pseudo-terminal, open as in lss-sim.
struct PseudoTerminal {
  int master = -1, slave = -1;
  std::string path;
  PseudoTerminal() {
    master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
    char name[64];
    if (grantpt(master) != 0 || unlockpt(master) != 0 || ptsname_r(master, name, sizeof name) != 0)
      std::abort();
    path = name;
    slave = open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  }
  ~PseudoTerminal() {
    close(slave);
    close(master);
  }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
};

class DoctorPorts : public Machine {
 protected:
  DoctorPorts() { config.vehicle = "zebro"; }
  Finding check(const std::string& path) {
    return check_port(system, config, {.name = "legs", .path = path});
  }
  // A serial port of hardware: a file with its permissions, and the answers of its driver.
  std::string serial_port(mode_t mode, SerialAnswer answer) {
    write("dev/ttyS1", "");
    chmod((root / "dev/ttyS1").c_str(), mode);
    system.ask_serial = [answer](const std::filesystem::path&) { return answer; };
    return root / "dev/ttyS1";
  }
};

TEST_F(DoctorPorts, SimulatedPortIsFoundByItsLinkInTheRunFolder) {
  const Finding absent = check("sim:legs");
  expect(absent, Result::problem, "run/legs is not there", "lss-sim zebro --dir");
  EXPECT_EQ(absent.name, "port/legs");
  const PseudoTerminal terminal;
  std::filesystem::create_symlink(terminal.path, root / "run/legs");
  process(70, "lss-sim", terminal.path);  // has both ends open
  expect(check("sim:legs"), Result::good,
         "run/legs (" + terminal.path + ") is free; low latency does not apply");
  process(71, "lssd", terminal.path);
  const Finding ours = check("sim:legs");
  expect(ours, Result::good, "open in lssd (pid 71)");
  EXPECT_THAT(ours.found, Not(HasSubstr("lss-sim")));
}

TEST_F(DoctorPorts, LinkOfASimulatorThatIsGoneCountsAsAbsent) {
  std::filesystem::create_symlink("/dev/pts/no-such", root / "run/legs");
  expect(check("sim:legs"), Result::problem, "is not there");
}

TEST_F(DoctorPorts, MissingDeviceIsAProblemWithAdvice) {
  expect(check("/dev/ttyNowhere7"), Result::problem, "/dev/ttyNowhere7 is not there", "by-id");
}

TEST_F(DoctorPorts, OtherProgramsThatHaveThePortOpenAreNamed) {
  const std::string path = serial_port(0666, {.terminal = true, .low_latency = true});
  expect(check(path), Result::good, "is free; low latency is on");
  process(getpid(), "lss-cli", path);  // ourselves do not count
  expect(check(path), Result::good, "is free");
  process(81, "minicom", path);
  expect(check(path), Result::problem, "open in minicom (pid 81)", "stop");
  process(82, "lssd", path);
  expect(check(path), Result::problem, "minicom (pid 81), lssd (pid 82)", "stop");
}

TEST_F(DoctorPorts, WhatIsNoTerminalIsNotOpened) {
  expect(check("/dev/null"), Result::problem, "/dev/null is no terminal", "serial port");
  expect(check(root), Result::problem, "is no terminal", "serial port");
  EXPECT_FALSE(ask_serial("/dev/null").terminal);
  EXPECT_EQ(ask_serial("/dev/ttyNowhere7").error, ENOENT);
  const PseudoTerminal terminal;
  const SerialAnswer answer = ask_serial(terminal.path);
  EXPECT_TRUE(answer.terminal);
  EXPECT_TRUE(answer.pseudo);
  EXPECT_FALSE(answer.low_latency.has_value());
}

TEST_F(DoctorPorts, LowLatencyIsReportedAsTheDriverHasIt) {
  expect(check(serial_port(0666, {.terminal = true, .low_latency = false})), Result::good,
         "off until lssd switches it on");
  expect(check(serial_port(0666, {.terminal = true})), Result::note, "16 ms");
}

TEST_F(DoctorPorts, RightsAreJudgedForThisUserAndForTheUnit) {
  expect(check(serial_port(0600, {.terminal = true, .low_latency = true})), Result::warning,
         "is free", "GROUP=\"dialout\"");
  expect(check(serial_port(0600, {.error = EACCES})), Result::problem, "Permission denied",
         "dialout");
  expect(check(serial_port(0600, {.error = EACCES, .pseudo = true})), Result::problem,
         "Permission denied", "same user");
  expect(check(serial_port(0666, {.error = EIO})), Result::problem, "Input/output error", "dmesg");
  const Finding unit_only = check(serial_port(0666, {.error = EACCES}));
  expect(unit_only, Result::note, "Permission denied", "usermod -aG dialout");
  EXPECT_THAT(unit_only.meaning, HasSubstr("666"));
}

TEST_F(DoctorPorts, LockedPortBelongsToTheDaemonOrToSomebodyUnseen) {
  const std::string path = serial_port(0666, {.error = EBUSY});
  expect(check(path), Result::problem, "busy", "fuser -v " + path);
  process(90, "lssd");
  const Finding ours = check(path);
  expect(ours, Result::note, "busy");
  EXPECT_THAT(ours.meaning, HasSubstr("lssd (pid 90)"));
}

TEST_F(DoctorPorts, WhatIsNoPortIsSaid) {
  expect(check("ttyS1"), Result::problem, "\"ttyS1\" is no port", "/dev/DEVICE");
  expect(check(""), Result::problem, "is no port", "sim:NAME");
  expect(check("udp://nowhere"), Result::problem, "is no address", "udp://127.0.0.1:PORT");
}

TEST_F(DoctorPorts, BusOverUdpNeedsAListener) {
  write("proc/net/udp",
        "  sl  local_address rem_address   st\n"
        "  7: 0100007F:4E20 00000000:0000 07\n");
  expect(check("udp://127.0.0.1:20000"), Result::good, "has a listener");
  expect(check("udp://127.0.0.1:20000?local=20001"), Result::good, "has a listener");
  expect(check("udp://127.0.0.1:20001"), Result::warning, "no listener", "lss-sim zebro");
  expect(check("udp://10.0.0.7:20000"), Result::note, "udp://10.0.0.7:20000");
}

TEST_F(DoctorPorts, CanInterfaceIsInTheKernelUpAndOnTheBus) {
  interface("can0", "0x40081", 280);
  expect(check("can0"), Result::good, "can0: up, error-active, 1000000 bit/s");
  EXPECT_EQ(check("can0").name, "port/legs");

  const auto with = [&](std::uint32_t state, std::uint32_t restart_ms = 100) {
    system.ask_can_link = [=](const std::string&) {
      return CanLink{.kind = "can", .state = state, .bitrate = 500'000, .restart_ms = restart_ms};
    };
    return check("can0");
  };
  expect(with(CAN_STATE_ERROR_WARNING), Result::warning, "error-warning", "termination");
  expect(with(CAN_STATE_ERROR_PASSIVE), Result::warning, "error-passive", "bit rate");
  expect(with(CAN_STATE_BUS_OFF), Result::problem, "bus-off", "ip link set can0 down");
  expect(with(CAN_STATE_STOPPED), Result::problem, "stopped", "ip link set can0 down");
  expect(with(CAN_STATE_ERROR_ACTIVE, 0), Result::note, "500000 bit/s", "restart-ms");

  interface("can0", "0x40080", 280);
  expect(check("can0"), Result::problem, "can0 is down", "ip link set can0 up type can bitrate");
  interface("can0", "0x1043", 1);
  expect(check("can0"), Result::problem, "no CAN interface", "ip link");
  expect(check("can1"), Result::problem, "no interface can1", "driver");
  expect(check("vcan1"), Result::problem, "no interface vcan1", "ip link add vcan1 type vcan");
  system.ask_can_socket = [] { return EAFNOSUPPORT; };
  expect(check("can0"), Result::problem, "not supported", "modprobe can_raw");
}

TEST_F(DoctorPorts, VirtualCanHasNoState) {
  interface("vcan0", "0x400c1", 280);
  system.ask_can_link = [](const std::string&) { return CanLink{.kind = "vcan"}; };
  expect(check("vcan0"), Result::good, "vcan0: up, virtual");
  system.ask_can_link = [](const std::string&) { return std::nullopt; };
  expect(check("vcan0"), Result::good, "state unknown");
}

// Attributes of a netlink message, byte by byte.
std::string attribute(unsigned short type, const std::string& content) {
  const auto length = static_cast<unsigned short>(4 + content.size());
  std::string bytes(4, '\0');
  std::memcpy(bytes.data(), &length, 2);
  std::memcpy(bytes.data() + 2, &type, 2);
  bytes += content;
  bytes.resize((bytes.size() + 3) / 4 * 4);
  return bytes;
}

std::string word(std::uint32_t value) {
  std::string bytes(4, '\0');
  std::memcpy(bytes.data(), &value, 4);
  return bytes;
}

CanLink parse(const std::string& bytes) { return parse_can_link(std::as_bytes(std::span(bytes))); }

TEST(DoctorCanLink, IsReadFromNetlinkAttributes) {
  constexpr unsigned short kNested = 0x8000;
  const std::string timing = word(250'000) + std::string(28, '\0');
  const std::string data = attribute(IFLA_CAN_BITTIMING, timing) +
                           attribute(IFLA_CAN_STATE, word(CAN_STATE_BUS_OFF)) +
                           attribute(IFLA_CAN_RESTART_MS, word(100));
  const std::string kind = attribute(IFLA_INFO_KIND, std::string("can\0", 4));
  const std::string message =
      attribute(IFLA_IFNAME, std::string("can0\0", 5)) +
      attribute(IFLA_LINKINFO | kNested, kind + attribute(IFLA_INFO_DATA | kNested, data));
  const CanLink link = parse(message);
  EXPECT_EQ(link.kind, "can");
  EXPECT_EQ(link.state, CAN_STATE_BUS_OFF);
  EXPECT_EQ(link.bitrate, 250'000U);
  EXPECT_EQ(link.restart_ms, 100U);
  for (std::size_t size = 0; size < message.size(); ++size) parse(message.substr(0, size));
  EXPECT_EQ(parse(message.substr(0, 20)).kind, "");
}

TEST(DoctorCanLink, IsAskedFromTheKernelThatTheTestsRunOn) {
  const std::optional<CanLink> loopback = ask_can_link("lo");
  ASSERT_TRUE(loopback.has_value());
  EXPECT_FALSE(loopback->state.has_value());
  EXPECT_FALSE(ask_can_link("nowhere7").has_value());
  EXPECT_FALSE(ask_can_link("much-too-long-a-name").has_value());
  EXPECT_FALSE(ask_can_link("").has_value());
}

using DoctorNetwork = Machine;

TEST_F(DoctorNetwork, InterfacesOfDdsMustBeUp) {
  expect(check_interface(system, "lo"), Result::good, "lo is up, without the multicast flag");
  interface("lo", "0x8", 772);
  expect(check_interface(system, "lo"), Result::problem, "lo is down", "ip link set lo up");
  expect(check_interface(system, "eth7"), Result::problem, "no interface eth7", "dds.interfaces");
  interface("eth0", "0x1003", 1);
  const Finding open = check_interface(system, "eth0");
  expect(open, Result::note, "eth0 is up, with the multicast flag");
  EXPECT_THAT(open.meaning, HasSubstr("neither authenticates"));
  EXPECT_EQ(open.name, "dds_interface/eth0");
  interface("eth0", "0x3", 1);
  expect(check_interface(system, "eth0"), Result::warning, "without", "multicast on");
}

TEST_F(DoctorNetwork, RoudiIsComparedWithTheConfiguration) {
  expect(check_roudi(system, &config), Result::good, "RouDi runs");
  expect(check_roudi(system, nullptr), Result::good, "RouDi runs");
  config.shared_memory = false;
  expect(check_roudi(system, &config), Result::note, "RouDi runs");
  system.find_roudi = [] { return std::nullopt; };
  expect(check_roudi(system, &config), Result::good, "not needed");
  config.shared_memory = true;
  expect(check_roudi(system, &config), Result::warning, "does not run", "iox-roudi");
  process(55, "iox-roudi");
  expect(check_roudi(system, &config), Result::note,
         "iox-roudi (pid 55) runs, but cannot be reached");
}

TEST_F(DoctorNetwork, SmallReceiveBuffersAndForeignConfigurationsAreNoted) {
  expect(check_buffers(system), Result::good, "4194304");
  write("proc/sys/net/core/rmem_max", "212992\n");
  expect(check_buffers(system), Result::note, "212992", "rmem_max=1048576");
  std::filesystem::remove(root / "proc/sys/net/core/rmem_max");
  expect(check_buffers(system), Result::good, "hidden");
  const char* given = getenv("CYCLONEDDS_URI");
  const std::string before = given != nullptr ? given : "";
  unsetenv("CYCLONEDDS_URI");
  expect(check_dds_uri(), Result::good, "not set");
  setenv("CYCLONEDDS_URI", "file:///etc/cyclone.xml", 1);
  expect(check_dds_uri(), Result::note, "file:///etc/cyclone.xml");
  if (given != nullptr) setenv("CYCLONEDDS_URI", before.c_str(), 1);
  if (given == nullptr) unsetenv("CYCLONEDDS_URI");
}

TEST(DoctorContract, IsWhatTheDaemonSaysOfItself) {
  lss_Status status{};
  status.realtime_granted = status.memory_locked = true;
  expect(judge_contract(status), Result::good,
         "policy degrade, all granted; memory locked; 0 page");
  status.realtime_enforced = true;
  expect(judge_contract(status), Result::good, "policy enforce");
  status.mallocs_since_start = 3;
  expect(judge_contract(status), Result::warning, "3 mallocs", "status");
  status.mallocs_since_start = 0;
  status.page_faults_since_start = 1;
  expect(judge_contract(status), Result::warning, "1 page faults", "status");
  status.page_faults_since_start = 0;
  status.memory_locked = false;
  expect(judge_contract(status), Result::warning, "not locked", "systemd");
  status.memory_locked = true;
  status.realtime_granted = false;
  expect(judge_contract(status), Result::warning, "not all granted", "systemd");
}

using DoctorConfig = Machine;

TEST_F(DoctorConfig, IsReadWithTheDefaultsOfTheDaemon) {
  write("zebro.toml", "vehicle = \"zebro\"\n[[port]]\nname = \"legs\"\npath = \"/dev/ttyS1\"\n");
  const auto least = read_config(root / "zebro.toml");
  ASSERT_TRUE(least.has_value());
  EXPECT_EQ(least->vehicle_id, "zebro-1");
  EXPECT_EQ(least->ports.at(0).path, "/dev/ttyS1");
  EXPECT_EQ(least->domain, 0);
  EXPECT_THAT(least->interfaces, ElementsAre("lo"));
  EXPECT_TRUE(least->shared_memory);

  write("all.toml",
        "vehicle = \"zebro\"\nvehicle_id = \"z7\"\n[realtime]\npolicy = \"enforce\"\n"
        "[[realtime.thread]]\nname = \"frame\"\npriority = 60\ncpu = 3\n"
        "[dds]\ndomain = 7\ninterfaces = [\"lo\", \"eth0\"]\nshared_memory = false\n");
  const auto all = read_config(root / "all.toml");
  ASSERT_TRUE(all.has_value());
  EXPECT_EQ(all->vehicle_id, "z7");
  EXPECT_TRUE(all->realtime_enforce);
  EXPECT_EQ(all->threads.at(0).name, "frame");
  EXPECT_EQ(all->threads.at(0).priority, 60);
  EXPECT_EQ(all->threads.at(0).cpu, 3);
  EXPECT_EQ(all->domain, 7);
  EXPECT_THAT(all->interfaces, ElementsAre("lo", "eth0"));
  EXPECT_FALSE(all->shared_memory);
}

TEST_F(DoctorConfig, OfOtherTypesAreLeftToTheDaemonToJudge) {
  write("odd.toml",
        "vehicle = 7\nport = \"legs\"\nrealtime = []\n[dds]\ndomain = \"x\"\ninterfaces = 3\n");
  const auto odd = read_config(root / "odd.toml");
  ASSERT_TRUE(odd.has_value());
  EXPECT_TRUE(odd->ports.empty());
  EXPECT_EQ(odd->domain, 0);
}

TEST_F(DoctorConfig, SyntaxErrorsComeWithFileAndLine) {
  write("broken.toml", "vehicle = \"zebro\"\n[[port]\n");
  const auto broken = read_config(root / "broken.toml");
  ASSERT_FALSE(broken.has_value());
  EXPECT_THAT(broken.error(),
              AllOf(StartsWith((root / "broken.toml:2:").string()), HasSubstr("not TOML")));
  EXPECT_THAT(read_config(root / "nowhere.toml").error(), HasSubstr("no such file"));
}

TEST_F(DoctorConfig, OfAllVehiclesAreFoundWithoutRoudis) {
  for (const char* name : {"zebro.toml", "roudi.toml", "zebro.toml.old", "second.toml"})
    write(std::string("etc/") + name, "");
  EXPECT_THAT(configurations(system),
              ElementsAre(root / "etc/second.toml", root / "etc/zebro.toml"));
  std::filesystem::remove_all(root / "etc");
  EXPECT_TRUE(configurations(system).empty());
}

TEST(DoctorReport, AlignsWrapsAndSums) {
  const Findings findings = {
      {"kernel", Result::good, "Linux", "good kernel", ""},
      {"port/legs", Result::problem, "one two three four five six seven", "cannot", "plug it in"},
      {"smt", Result::note, "on", "shared", ""},
  };
  EXPECT_EQ(report_text(findings, Style{}, {.width = 50}),
            "good     kernel     Linux\n"
            "problem  port/legs  one two three four five six\n"
            "                    seven\n"
            "                    cannot\n"
            "                    -> plug it in\n"
            "note     smt        on\n"
            "                    shared\n"
            "1 problem, no warnings, 1 note\n");
  EXPECT_THAT(report_text(findings, Style{}, {.width = 50, .explain = true}),
              HasSubstr("good kernel"));
  EXPECT_THAT(report_text(findings, Style{true}, {}),
              HasSubstr("\x1b[1;31mproblem\x1b[0m  port/legs"));
  EXPECT_TRUE(has_problem(findings));
  EXPECT_FALSE(has_problem({findings[0], findings[2]}));
}

}  // namespace
}  // namespace lss::cli::test
