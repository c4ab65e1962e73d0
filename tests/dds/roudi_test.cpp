// The telemetry plane while RouDi runs, is absent, ends, is replaced, and drops us; and the control
// plane, which is to notice nothing of it. Each case runs in a process of its own and ends with
// exit().

#include "idl/roudi.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>
#include <zebro.h>  // of the IDL

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "daemon/publish/face.h"
#include "tests/dds/dds_support.h"
#include "tests/dds/roudi_support.h"

namespace lss {
namespace {

using namespace testing_support;

// On a machine under load a process could really stand still, which is another scenario. Threads
// and RouDi have the priority of who starts them.
void never_stand_still() {
  const sched_param lowest{.sched_priority = 1};
  if (::sched_setscheduler(0, SCHED_FIFO, &lowest) != 0)
    std::fputs("no permission for SCHED_FIFO: load may look like a standstill\n", stderr);
}

void expect_success(void (*scenario)()) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        ::alarm(100);  // a scenario that hangs, also while it leaves, fails
        never_stand_still();
        scenario();
        std::exit(0);
      },
      testing::ExitedWithCode(0), "");
}

std::vector<std::string> telemetry_stranger(int count, bool keep_all = false) {
  std::vector<std::string> command{DDS_STRANGER, "telemetry", std::to_string(test_domain()),
                                   std::to_string(count), "30"};
  if (keep_all) command.emplace_back("keep-all");
  return command;
}

// A reader that starts now, as any program would, gets telemetry.
void require_heard(bool shared_memory, const std::string& when) {
  Child stranger(telemetry_stranger(10), loopback_uri(shared_memory));
  require(stranger.wait_for_exit(std::chrono::seconds(30)) == 0,
          std::string("a late ") + (shared_memory ? "shared-memory" : "network") +
              " reader hears " + when + ": " + stranger.output());
}

// A face whose daemon accepts every command, and its client.
class Daemon {
 public:
  Daemon() {
    face_ = value(
        Face::create(face_parameters("v1", true), [this](const Request& request, std::uint64_t) {
          if (request.kind != 0) {
            face_->acknowledge(
                {request.source, request.sequence, request.kind, Phase::accepted, {}, 0});
          }
        }));
  }

  Face& face() { return *face_; }
  void connect() {
    client_.emplace(test_domain(), "v1");
    require(eventually([this] { return client_->connected(); }), "the client finds the face");
  }
  void require_control(const std::string& when) {
    const lss_Command command = client_->command(1);
    require(client_->send(command), "a command is sent " + when);
    require(eventually([&] {
              const auto& acks = client_->acks();
              return !acks.empty() && acks.back().seq == command.seq;
            }),
            "a command is acknowledged " + when);
  }
  lss_Status status() {
    const std::size_t before = client_->statuses().size();
    face_->status({});
    require(eventually([&] { return client_->statuses().size() > before; }), "a status arrives");
    return client_->statuses().back();
  }

 private:
  std::unique_ptr<Face> face_;
  std::optional<Client> client_;
};

void a_reader_from_the_idl_gets_loaned_samples_and_no_datagram_is_sent() {
  const Alone alone;
  Roudi roudi;
  Daemon daemon;
  require(daemon.face().shared_memory() == SharedMemory::active, "shared memory is taken up");
  require(!daemon.face().shared_memory_could_return(), "it is here and need not return");
  Publisher publisher(daemon.face());
  Child stranger(telemetry_stranger(50), loopback_uri(true));
  require(stranger.wait_for_line("ready shm=1 loan=1"), "the stranger is on shared memory");
  require(stranger.wait_for_exit() == 0, "the stranger gets its samples: " + stranger.output());
  require(publisher.samples() > 50, "there was something to send");
  require(publisher.datagrams() == 0, "no datagram for telemetry");
  require_heard(false, "a shared-memory writer");
  Child keep_all(telemetry_stranger(10, true), loopback_uri(true));
  require(keep_all.wait_for_line("ready shm=0"), "keep-all stays off shared memory");
  require(keep_all.wait_for_exit() == 0, "a keep-all reader hears a shared-memory writer");
  require(publisher.datagrams() > 0, "those two were served by datagrams, which are counted");
}

void without_roudi_the_network_carries_it_and_status_says_so() {
  const Alone alone;
  Daemon daemon;
  require(daemon.face().shared_memory() == SharedMemory::absent, "RouDi is missed");
  daemon.connect();
  daemon.require_control("without RouDi");
  const lss_Status status = daemon.status();
  require(status.shared_memory == lss_SHM_ABSENT, "status says absent");
  require(std::string(status.shared_memory_text).find("iox-roudi") != std::string::npos,
          "status says what to do");
  Publisher publisher(daemon.face());
  require_heard(false, "without RouDi");
  require(!daemon.face().shared_memory_could_return(), "nothing to return to");
  Roudi roudi;
  require(eventually([&] { return daemon.face().shared_memory_could_return(); }), "RouDi came");
  require_heard(true, "a face that started before RouDi");
  require(publisher.changes() == 0, "nothing changed meanwhile");
}

void killing_roudi_moves_telemetry_to_the_network_for_old_and_new_readers() {
  const Alone alone;
  std::optional<Roudi> roudi(std::in_place);
  Daemon daemon;
  daemon.connect();
  Publisher publisher(daemon.face());
  Child old(telemetry_stranger(1'000'000), loopback_uri(true));
  require(old.wait_for_line("ready shm=1"), "a reader on shared memory");
  daemon.require_control("while RouDi runs");

  roudi->kill();
  require(eventually([&] { return daemon.face().shared_memory() == SharedMemory::lost; }),
          "the loss is noticed");
  require(eventually([&] { return publisher.changes() == 1; }), "the loss is reported once");
  daemon.require_control("after RouDi ended");
  require_heard(false, "after RouDi ended");
  require(!daemon.face().shared_memory_could_return(), "no RouDi to return to");

  roudi.reset();
  roudi.emplace();
  require(eventually([&] { return daemon.face().shared_memory_could_return(); }),
          "RouDi is there again");
  require(daemon.face().shared_memory() == SharedMemory::lost, "but not taken up by itself");
  require_heard(true, "with the next RouDi");
  daemon.require_control("with the next RouDi");
}

void a_reader_on_shared_memory_goes_on_hearing_after_roudi_died() {
  const Alone alone;
  std::optional<Roudi> roudi(std::in_place);
  Daemon daemon;
  Publisher publisher(daemon.face());
  Child old(telemetry_stranger(500), loopback_uri(true));
  require(old.wait_for_line("ready shm=1"), "a reader on shared memory");
  roudi->kill();
  require(eventually([&] { return daemon.face().shared_memory() == SharedMemory::lost; }),
          "the loss is noticed");
  require(old.wait_for_exit(std::chrono::seconds(30)) == 0, "it gets the rest: " + old.output());
}

void a_roudi_replaced_between_two_looks_is_noticed() {
  const Alone alone;
  std::optional<Roudi> roudi(std::in_place);
  Daemon daemon;
  require(!daemon.face().watch_shared_memory(), "all is well");
  roudi.reset();
  roudi.emplace();
  require(daemon.face().watch_shared_memory(), "the change is noticed");
  require(daemon.face().shared_memory() == SharedMemory::lost, "it is a loss");
  require(!daemon.face().watch_shared_memory(), "it is reported once");
  Publisher publisher(daemon.face());
  require_heard(true, "after the change");
  require_heard(false, "after the change");
}

// Lets this process go on, which stops itself, when RouDi has dropped it.
class Waker {
 public:
  explicit Waker(const Roudi& roudi)
      : log_file_(roudi.log_file()),
        child_({"sh", "-c",
                "n=0; until grep -q 'removing it' " + log_file_ +
                    " || [ $n -gt 600 ]; do sleep 0.05; n=$((n+1)); done; kill -CONT " +
                    std::to_string(::getpid())}) {}
  // After the standstill.
  void require_dropped() {
    require(child_.wait_for_exit(std::chrono::seconds(60)) == 0, "we go on");
    std::ifstream log(log_file_);
    const std::string text(std::istreambuf_iterator<char>(log), {});
    std::filesystem::remove(log_file_);
    require(text.find("removing it") != std::string::npos, "RouDi dropped us");
  }

 private:
  std::string log_file_;
  Child child_;
};

// RouDi frees the resources of a client without keep-alive for 1.5 s; iceoryx aborts a client that
// then goes on, and never lets it leave.
void a_standstill_that_made_roudi_drop_us_is_survived() {
  const Alone alone;
  static Roudi roudi;  // outlives us: the exit while it runs is the difficult part
  Daemon daemon;
  daemon.connect();
  Publisher publisher(daemon.face());
  require(eventually([&] { return publisher.samples() > 10; }), "telemetry runs");
  Waker waker(roudi);
  publisher.stop_process();
  waker.require_dropped();
  require(eventually([&] { return daemon.face().shared_memory() == SharedMemory::lost; }),
          "the standstill is noticed");
  require(eventually([&] { return daemon.face().shared_memory_could_return(); }), "RouDi runs");
  daemon.require_control("after the standstill");
  require_heard(false, "after the standstill");
}

// Without another sample, the way out would never end.
void a_standstill_before_the_end_is_survived() {
  const Alone alone;
  static Roudi roudi;  // outlives us
  Daemon daemon;
  const lss_ZebroTelemetry telemetry{};
  daemon.face().telemetry(&telemetry);
  Waker waker(roudi);
  ::raise(SIGSTOP);
  waker.require_dropped();
}

// Simulated time may stand for minutes, and RouDi's clock goes on.
void a_publisher_without_anything_to_send_stays_on_shared_memory() {
  const Alone alone;
  Roudi roudi;
  Daemon daemon;
  const lss_ZebroTelemetry telemetry{};
  daemon.face().telemetry(&telemetry);
  std::this_thread::sleep_for(std::chrono::seconds(3));
  daemon.face().telemetry(&telemetry);
  require(!daemon.face().watch_shared_memory(), "nothing changed");
  require(daemon.face().shared_memory() == SharedMemory::active, "shared memory is kept");
}

void a_request_of_the_user_for_shared_memory_without_roudi_does_not_abort() {
  const Alone alone;
  ::setenv("CYCLONEDDS_URI", "<SharedMemory><Enable>true</Enable></SharedMemory>", 1);
  const auto participant =
      value(dds::Participant::create({.domain = test_domain(), .shared_memory = true}));
  require(!participant.roudi(), "no RouDi");
}

// iceoryx would wait a minute for it, and then abort the process.
void a_roudi_that_hangs_is_not_joined() {
  const Alone alone;
  Roudi roudi;
  require(dds::roudi_answers(std::chrono::seconds(60)), "RouDi answers");
  roudi.halt();
  Daemon daemon;
  require(daemon.face().shared_memory() == SharedMemory::absent, "it is not joined");
  daemon.connect();
  const lss_Status status = daemon.status();
  require(std::string(status.shared_memory_text).find("RouDi hung") != std::string::npos,
          "status says why");
  Publisher publisher(daemon.face());
  require_heard(false, "beside a RouDi that hangs");
  // More than its queue takes.
  for (int looks = 0; looks < 1000; ++looks)
    require(!daemon.face().shared_memory_could_return(), "nothing to return to");
  roudi.go_on();
  require(eventually([&] { return daemon.face().shared_memory_could_return(); }), "it answers");
}

void every_roudi_has_an_identity_of_its_own() {
  const Alone alone;
  std::optional<Roudi> roudi(std::in_place);
  const auto first = dds::find_roudi();
  require(first && first == dds::find_roudi(), "one RouDi is one");
  roudi->kill();
  require(std::filesystem::exists("/tmp/roudi"), "a killed RouDi leaves its socket file behind");
  roudi.reset();
  roudi.emplace();
  require(dds::find_roudi().has_value() && dds::find_roudi() != first, "the next is another");
}

TEST(SharedMemoryPlane, AReaderMadeFromTheIdlAloneGetsLoanedSamplesAndNoDatagramIsSent) {
  expect_success(a_reader_from_the_idl_gets_loaned_samples_and_no_datagram_is_sent);
}
TEST(SharedMemoryPlane, WithoutRoudiAtStartTheNetworkCarriesTelemetryAndStatusSaysSo) {
  expect_success(without_roudi_the_network_carries_it_and_status_says_so);
}
TEST(SharedMemoryPlane, KillingRoudiMovesTelemetryToTheNetworkAndControlNoticesNothing) {
  expect_success(killing_roudi_moves_telemetry_to_the_network_for_old_and_new_readers);
}
TEST(SharedMemoryPlane, AReaderOnSharedMemoryGoesOnHearingAfterRoudiDied) {
  expect_success(a_reader_on_shared_memory_goes_on_hearing_after_roudi_died);
}
TEST(SharedMemoryPlane, ARoudiReplacedBetweenTwoLooksIsNoticed) {
  expect_success(a_roudi_replaced_between_two_looks_is_noticed);
}
TEST(SharedMemoryPlane, AStandstillThatMadeRoudiDropUsIsSurvivedAndLeft) {
  expect_success(a_standstill_that_made_roudi_drop_us_is_survived);
}
TEST(SharedMemoryPlane, AStandstillBeforeTheEndIsSurvived) {
  expect_success(a_standstill_before_the_end_is_survived);
}
TEST(SharedMemoryPlane, APublisherWithoutAnythingToSendStaysOnSharedMemory) {
  expect_success(a_publisher_without_anything_to_send_stays_on_shared_memory);
}
TEST(SharedMemoryPlane, ARequestOfTheUserForSharedMemoryWithoutRoudiDoesNotAbort) {
  expect_success(a_request_of_the_user_for_shared_memory_without_roudi_does_not_abort);
}
TEST(SharedMemoryPlane, ARoudiThatHangsIsNotJoined) {
  expect_success(a_roudi_that_hangs_is_not_joined);
}
TEST(Roudi, EveryOneHasAnIdentityOfItsOwn) {
  expect_success(every_roudi_has_an_identity_of_its_own);
}

}  // namespace
}  // namespace lss
