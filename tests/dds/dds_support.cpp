#include "tests/dds/dds_support.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>

#include "daemon/publish/convert.h"
#include "tests/support/own_domain.h"

namespace lss::testing_support {

int test_domain() { return testing_support::own_domain(); }

Child::Child(const std::vector<std::string>& command, const std::string& uri) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe2");
  pipe_ = ends[0];

  std::vector<char*> argv;
  argv.reserve(command.size() + 1);
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  std::string uri_variable = "CYCLONEDDS_URI=" + uri;
  std::vector<char*> environment;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (!std::string_view(*variable).starts_with("CYCLONEDDS_URI=")) {
      environment.push_back(*variable);
    }
  }
  if (!uri.empty()) environment.push_back(uri_variable.data());
  environment.push_back(nullptr);

  pid_ = ::fork();
  if (pid_ == 0) {  // only calls that are safe in a fork of a program with threads
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::dup2(ends[1], STDOUT_FILENO);
    ::execvpe(argv[0], argv.data(), environment.data());
    ::_exit(127);
  }
  ::close(ends[1]);
  if (pid_ < 0) throw std::runtime_error("fork");
}

Child::~Child() {
  if (!exit_) {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  ::close(pipe_);
}

void Child::halt() const {
  signal(SIGSTOP);
  siginfo_t stopped{};
  ::waitid(P_PID, static_cast<id_t>(pid_), &stopped, WSTOPPED);
}

void Child::signal(int number) const { ::kill(pid_, number); }

// False at the end of the output, which is when the child has ended.
bool Child::read_more(std::chrono::milliseconds limit) {
  pollfd readable{pipe_, POLLIN, 0};
  if (::poll(&readable, 1, static_cast<int>(limit.count())) <= 0) return true;
  char text[512];
  const ssize_t count = ::read(pipe_, text, sizeof text);
  if (count > 0) output_.append(text, static_cast<std::size_t>(count));
  return count > 0;
}

bool Child::wait_for_line(std::string_view part, std::chrono::seconds limit) {
  const auto end = std::chrono::steady_clock::now() + limit;
  const auto found = [&] { return output_.find(part) != std::string::npos; };
  while (!found() && read_more(std::chrono::milliseconds(5)) &&
         std::chrono::steady_clock::now() < end) {
  }
  return found();
}

std::optional<int> Child::wait_for_exit(std::chrono::seconds limit) {
  const auto ended = [this] {
    if (exit_) return true;
    int status = 0;
    if (::waitpid(pid_, &status, WNOHANG) != pid_) return false;
    exit_ = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    return true;
  };
  if (!eventually(ended, limit)) return {};
  while (read_more(std::chrono::milliseconds(20))) {
  }
  return exit_;
}

std::string loopback_uri(bool shared_memory) {
  return std::string(
             "<General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/>"
             "</Interfaces></General><SharedMemory><Enable>") +
         (shared_memory ? "true" : "false") + "</Enable><LogLevel>warn</LogLevel></SharedMemory>";
}

RequestSink Requests::sink() {
  return [this](const Request& request, std::uint64_t writer) {
    const std::lock_guard lock(mutex_);
    requests_.push_back(request);
    writers_.push_back(writer);
  };
}

std::vector<std::uint64_t> Requests::writers() const {
  const std::lock_guard lock(mutex_);
  return writers_;
}

std::vector<Request> Requests::all() const {
  const std::lock_guard lock(mutex_);
  return requests_;
}

std::vector<Request> Requests::commands() const {
  std::vector<Request> result = all();
  std::erase_if(result, [](const Request& r) { return r.kind == 0; });
  return result;
}

std::vector<Request> Requests::heartbeats() const {
  std::vector<Request> result = all();
  std::erase_if(result, [](const Request& r) { return r.kind != 0; });
  return result;
}

Client::Client(int domain, const std::string& vehicle_id, const std::string& source)
    : vehicle_id_(vehicle_id),
      source_(source),
      participant_(value(dds::Participant::create({.domain = domain}))),
      command_(
          value(dds::create_writer(participant_.get(), dds::common_topic(dds::Kind::command)))),
      heartbeat_out_(
          value(dds::create_writer(participant_.get(), dds::common_topic(dds::Kind::heartbeat)))),
      ack_(
          value(dds::create_reader(participant_.get(), dds::common_topic(dds::Kind::command_ack)))),
      event_(value(dds::create_reader(participant_.get(), dds::common_topic(dds::Kind::event)))),
      status_(value(dds::create_reader(participant_.get(), dds::common_topic(dds::Kind::status)))),
      heartbeat_(
          value(dds::create_reader(participant_.get(), dds::common_topic(dds::Kind::heartbeat)))) {}

bool Client::connected() const {
  const auto writer_matched = [](const dds::Entity& writer) {
    dds_publication_matched_status_t status;
    return dds_get_publication_matched_status(writer.get(), &status) == DDS_RETCODE_OK &&
           status.current_count > 0;
  };
  const auto reader_matched = [](const dds::Entity& reader) {
    dds_subscription_matched_status_t status;
    return dds_get_subscription_matched_status(reader.get(), &status) == DDS_RETCODE_OK &&
           status.current_count > 0;
  };
  return writer_matched(command_) && writer_matched(heartbeat_out_) && reader_matched(ack_) &&
         reader_matched(event_) && reader_matched(status_) && reader_matched(heartbeat_);
}

lss_Command Client::command(std::uint16_t kind) const {
  lss_Command sample{};
  dds::copy_text(vehicle_id_, sample.vehicle_id);
  dds::copy_text(source_, sample.source);
  sample.seq = ++sequence_;
  sample.kind = kind;
  return sample;
}

bool Client::send(const lss_Command& command) {
  return dds_write(command_.get(), &command) == DDS_RETCODE_OK;
}

bool Client::send(const lss_Heartbeat& heartbeat) {
  return dds_write(heartbeat_out_.get(), &heartbeat) == DDS_RETCODE_OK;
}

FaceParameters face_parameters(const std::string& vehicle_id, bool shared_memory) {
  return {.domain = test_domain(),
          .vehicle = "zebro",
          .vehicle_id = vehicle_id,
          .version = "0.1.0",
          .shared_memory = shared_memory};
}

}  // namespace lss::testing_support
