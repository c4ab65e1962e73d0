#include "tests/bench/programs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <thread>

#include "daemon/runtime/clock.h"
#include "idl/roudi.h"

namespace lss::bench {
namespace {

std::filesystem::path source() { return LSS_BENCH_SOURCE; }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("config/zebro.toml has no: " + from);
  return text.replace(at, from.size(), to);
}

// A line of /proc/PID/status; kNone when there is none.
double memory_mb(pid_t pid, std::string_view what) {
  const std::string status = read_file(fmt::format("/proc/{}/status", pid));
  const std::size_t at = status.find(what);
  return at == std::string::npos ? kNone : std::stod(status.substr(at + what.size())) * 1024 / 1e6;
}

}  // namespace

std::string shipped_config(const std::string& vehicle) {
  return read_file(source() / "config" / (vehicle + ".toml"));
}

std::string edited(std::string text, const std::string& key, const std::string& to) {
  const std::regex line("(^|\n)" + key + " *= *[^#\n]*");
  std::smatch found;
  if (!std::regex_search(text, found, line))
    throw std::runtime_error("no key in the config: " + key);
  return text.replace(static_cast<std::size_t>(found.position()),
                      static_cast<std::size_t>(found.length()),
                      found[1].str() + key + " = " + to + " ");
}

std::string program(const std::string& name) {
  for (const std::filesystem::path& folder :
       {std::filesystem::read_symlink("/proc/self/exe").parent_path(),
        std::filesystem::path(LSS_BENCH_REFERENCES)}) {
    if (std::filesystem::exists(folder / name)) return folder / name;
  }
  throw NotHere(name + " is not built: ninja " + name);
}

Process::Process(const std::vector<std::string>& words, const std::filesystem::path& output,
                 const Environment& environment)
    : name_(std::filesystem::path(words.front()).filename()), output_(output) {
  const auto ours = [](std::string_view variable) {
    const std::string_view name = variable.substr(0, variable.find('='));
    return name == "CYCLONEDDS_URI" || name == "NOTIFY_SOCKET" || name == "ROS_DOMAIN_ID" ||
           name.starts_with("LSS_");
  };
  std::vector<std::string> variables;
  for (char** v = environ; *v != nullptr; ++v) {
    if (!ours(*v)) variables.emplace_back(*v);
  }
  for (const auto& [name, value] : environment)
    variables.push_back(fmt::format("{}={}", name, value));
  const auto pointers = [](const std::vector<std::string>& texts) {
    std::vector<char*> result;
    result.reserve(texts.size() + 1);
    for (const std::string& text : texts) result.push_back(const_cast<char*>(text.c_str()));
    result.push_back(nullptr);
    return result;
  };
  const std::vector<char*> argv = pointers(words), envp = pointers(variables);

  const int out = ::open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (out < 0) throw NotHere("cannot write " + output.string());
  started_ns_ = now_ns();
  pid_ = ::fork();
  if (pid_ == 0) {  // only calls that are safe in a fork of a program with threads
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::dup2(out, STDOUT_FILENO);
    ::dup2(out, STDERR_FILENO);
    ::execvpe(argv[0], argv.data(), envp.data());
    ::_exit(127);
  }
  ::close(out);
  if (pid_ < 0) throw NotHere("no process can be started");
}

Process::~Process() {
  if (!running()) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

bool Process::said(const std::string& text) const {
  return read_file(output_).find(text) != std::string::npos;
}

bool Process::running() {
  if (exit_) return false;
  int status = 0;
  if (::waitpid(pid_, &status, WNOHANG) != pid_) return true;
  exit_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  return false;
}

void Process::signal(int number) const { ::kill(pid_, number); }

int Process::wait(std::chrono::seconds limit) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (running()) {
    if (const double peak_mb = memory_mb(pid_, "VmHWM:"); std::isfinite(peak_mb))
      peak_mb_ = peak_mb;  // not of rusage, which begins with the memory of this process
    if (std::chrono::steady_clock::now() > end)
      throw std::runtime_error(fmt::format("{} did not end within {} s", name_, limit.count()));
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  if (*exit_ == 127) throw NotHere(name_ + " is not installed: see tools/packages.txt");
  return *exit_;
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

double rss_mb(pid_t pid) { return memory_mb(pid, "VmRSS:"); }

namespace {

// So far: CPU time of the machine without that of this process and its ended children.
double others_s() {
  std::istringstream stat(read_file("/proc/stat"));
  std::string cpu;
  double user = 0, nice = 0, system = 0, idle = 0, wait = 0, irq = 0, soft_irq = 0, steal = 0;
  stat >> cpu >> user >> nice >> system >> idle >> wait >> irq >> soft_irq >> steal;
  double busy_s =
      (user + nice + system + irq + soft_irq + steal) / static_cast<double>(::sysconf(_SC_CLK_TCK));
  for (const int whose : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    ::getrusage(whose, &used);
    for (const timeval& t : {used.ru_utime, used.ru_stime})
      busy_s -= static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  }
  return busy_s;
}

}  // namespace

Others::Others() : begin_ns_(now_ns()), begin_s_(others_s()) {}

double Others::share() const {
  const double elapsed_s = static_cast<double>(now_ns() - begin_ns_) * 1e-9;
  return (others_s() - begin_s_) / elapsed_s / std::thread::hardware_concurrency();
}

OnCpu::OnCpu(int cpu) {
  ::sched_getaffinity(0, sizeof before_, &before_);
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<std::size_t>(cpu), &set);
  ::sched_setaffinity(0, sizeof set, &set);
}

OnCpu::~OnCpu() { ::sched_setaffinity(0, sizeof before_, &before_); }

ReadySocket::ReadySocket(const std::filesystem::path& folder)
    : path_(folder / "ready"), fd_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path_.copy(address.sun_path, sizeof address.sun_path - 1);
  if (::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw NotHere("no socket can be made at " + path_);
}

ReadySocket::~ReadySocket() { ::close(fd_); }

TimeNs ReadySocket::wait(std::chrono::seconds limit) {
  const TimeNs end = now_ns() + limit.count() * kSecond;
  for (TimeNs now = now_ns(); now < end; now = now_ns()) {
    pollfd readable{fd_, POLLIN, 0};
    if (::poll(&readable, 1, static_cast<int>((end - now) / kMillisecond) + 1) <= 0) break;
    const TimeNs heard_ns = now_ns();
    char text[256];
    const ssize_t size = ::recv(fd_, text, sizeof text, 0);
    if (size > 0 && std::string_view(text, static_cast<std::size_t>(size)).find("READY=1") !=
                        std::string_view::npos)
      return heard_ns;
  }
  throw std::runtime_error("the program did not say that it is ready");
}

std::pair<std::string, std::string> loopback(bool shared_memory) {
  return {"CYCLONEDDS_URI",
          std::string("<General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/>"
                      "</Interfaces></General><SharedMemory><Enable>") +
              (shared_memory ? "true" : "false") +
              "</Enable><LogLevel>warn</LogLevel></SharedMemory>"};
}

void Service::start(const std::vector<std::string>& words, Process::Environment environment) {
  ReadySocket ready(folder_);
  environment.push_back(ready.variable());
  process_.emplace(words, folder_ / "service.log", environment);
  ready_ns_ = ready.wait();
}

Daemon::Daemon(int domain, bool shared_memory, const std::filesystem::path& enclave,
               const std::string& vehicle_id) {
  std::string text = shipped_config("zebro");
  if (!shared_memory) text = replaced(text, "shared_memory = true", "shared_memory = false");
  text = replaced(text, "\"zebro-1\"", '"' + vehicle_id + '"');
  text = replaced(text, "enclave = \"\"", "enclave = \"" + enclave.string() + "\"");
  const std::filesystem::path config = folder_ / "zebro.toml";
  std::ofstream(config) << text;
  start({program("lssd"), "--config", config, "--run-dir", folder_, "--domain",
         std::to_string(domain)},
        {});
}

Cyclictest::Cyclictest(int priority, TimeNs period_ns, int cycles, int cpu, Unit unit)
    : cycles_(cycles), unit_us_(unit == Unit::nanoseconds ? 1e-3 : 1) {
  std::vector<std::string> words{"cyclictest",
                                 "-q",
                                 "-m",
                                 "-p",
                                 std::to_string(priority),
                                 "-i",
                                 std::to_string(period_ns / kMicrosecond),
                                 "-l",
                                 std::to_string(cycles),
                                 "-a",
                                 std::to_string(cpu),
                                 "--json=" + (folder_ / "result.json").string()};
  if (unit == Unit::nanoseconds) {
    words.insert(words.end(), {"-N", "-h", counts_instructions ? "100000" : "1000000"});
  } else {
    words.insert(words.end(), {"-h", "20000"});
  }
  if (counts_instructions) words.emplace_back("--laptop");
  process_.emplace(words, "/dev/null");
}

Samples Cyclictest::latencies() {
  if (const int code = process_->wait(std::chrono::minutes(15)); code != 0)
    throw NotHere(fmt::format("cyclictest does not run here (exit code {})", code));
  const auto result = nlohmann::json::parse(read_file(folder_ / "result.json"));
  const auto& thread = result.at("thread").at("0");
  Samples samples;
  for (const auto& [latency, count] : thread.at("histogram").items())
    samples.insert(samples.end(), count.get<std::size_t>(), std::stod(latency) * unit_us_);
  // Samples outside the histogram.
  const double most = thread.at("max").get<double>() * unit_us_;
  if (samples.size() < static_cast<std::size_t>(cycles_))
    samples.resize(static_cast<std::size_t>(cycles_), most);
  return samples;
}

Roudi::Roudi() {
  process_.emplace(std::vector<std::string>{"iox-roudi", "-c", source() / "config" / "roudi.toml"},
                   folder_ / "roudi.log");
  if (!eventually([&] { return process_->said("ready for clients"); }))
    throw NotHere("RouDi does not start here");
}

}  // namespace lss::bench
