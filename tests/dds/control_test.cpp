// The control plane end to end: a face and its clients over loopback.

#include <earlier.h>  // of the IDL
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "daemon/publish/convert.h"
#include "daemon/publish/face.h"
#include "daemon/runtime/clock.h"
#include "idl/zebro/commands.h"
#include "tests/dds/dds_support.h"
#include "zebro.h"

namespace lss {
namespace {

using namespace testing_support;

constexpr auto kStart = std::uint16_t{1};
constexpr auto kEstop = static_cast<std::uint16_t>(CommandKind::emergency_stop);

class Control : public testing::Test {
 protected:
  Control() {
    face_ = value(Face::create(face_parameters("v1"), requests_.sink()));
    client_ = std::make_unique<Client>(test_domain(), "v1");
  }
  void SetUp() override {
    ASSERT_TRUE(eventually([this] { return client_->connected(); }));
  }
  // The face last: it was first, so it owns the domain of this process.
  ~Control() override {
    client_.reset();
    face_.reset();
  }

  Requests requests_;
  std::unique_ptr<Face> face_;
  std::unique_ptr<Client> client_;
};

TEST_F(Control, EveryPhaseOfAnAcknowledgementArrivesInOrder) {
  lss_Command command = client_->command(kStart);
  ASSERT_TRUE(client_->send(command));
  ASSERT_TRUE(eventually([&] { return !requests_.commands().empty(); }));
  const Request request = requests_.commands().front();
  for (const Phase phase : {Phase::accepted, Phase::executing, Phase::completed, Phase::rejected,
                            Phase::failed, Phase::superseded}) {
    Ack ack{request.source, request.sequence, request.kind, phase, {}, now_ns()};
    if (phase == Phase::failed) ack.verdict = {Reason::module_silent, 5000, 200, 3};
    face_->acknowledge(ack);
  }
  ASSERT_TRUE(eventually([&] { return client_->acks().size() == 6; }));
  const auto& acks = client_->acks();
  const lss_Phase expected[] = {lss_PHASE_ACCEPTED, lss_PHASE_EXECUTING, lss_PHASE_COMPLETED,
                                lss_PHASE_REJECTED, lss_PHASE_FAILED,    lss_PHASE_SUPERSEDED};
  for (std::size_t i = 0; i < std::size(expected); ++i) {
    EXPECT_EQ(acks[i].phase, expected[i]);
    EXPECT_EQ(acks[i].seq, command.seq);
    EXPECT_STREQ(acks[i].source, "client");
    EXPECT_STREQ(acks[i].vehicle_id, "v1");
  }
  EXPECT_EQ(acks[4].reason, static_cast<std::uint16_t>(Reason::module_silent));
  EXPECT_EQ(acks[4].measured, 5000);
  EXPECT_EQ(acks[4].limit, 200);
  EXPECT_THAT(acks[4].text, testing::HasSubstr("module 3 does not answer"));
  EXPECT_TRUE(std::isnan(acks[0].measured));
}

TEST_F(Control, TheSinkMayAcknowledgeFromWithinTheCall) {
  Face* face = nullptr;
  FaceParameters parameters = face_parameters("v2");
  const auto owner = value(Face::create(parameters, [&face](const Request& request, std::uint64_t) {
    face->acknowledge({request.source, request.sequence, request.kind, Phase::accepted, {}, 0});
  }));
  face = owner.get();
  Client client(test_domain(), "v2");
  ASSERT_TRUE(eventually([&] { return client.connected(); }));
  ASSERT_TRUE(client.send(client.command(kStart)));
  EXPECT_TRUE(eventually([&] { return client.acks().size() == 1; }));
}

TEST_F(Control, HeartbeatsOfClientsComeInWithKindZeroAndTheirCounter) {
  lss_Heartbeat beat{};
  dds::copy_text("v1", beat.vehicle_id);
  dds::copy_text("obc", beat.source);
  beat.counter = 41;
  ASSERT_TRUE(eventually([&] {
    client_->send(beat);
    return !requests_.heartbeats().empty();
  }));
  const Request request = requests_.heartbeats().front();
  EXPECT_EQ(request.sequence, 41u);
  EXPECT_STREQ(request.source.data(), "obc");
  EXPECT_LE(request.arrival_ns, now_ns());
  EXPECT_GT(request.arrival_ns, now_ns() - 20 * kSecond);
}

TEST_F(Control, TheFaceDoesNotHearItsOwnHeartbeatButThatOfAnotherDaemonOfItsName) {
  const auto flags = [&] {
    std::vector<std::uint16_t> all;
    for (const Request& request : requests_.heartbeats()) all.push_back(request.flags);
    return all;
  };
  face_->heartbeat(State::idle);
  // A later sample has arrived, so the earlier one would have arrived, too.
  lss_Heartbeat beat{};
  dds::copy_text("v1", beat.vehicle_id);
  dds::copy_text("obc", beat.source);
  ASSERT_TRUE(eventually([&] {
    client_->send(beat);
    return !requests_.heartbeats().empty();
  }));
  EXPECT_THAT(flags(), testing::Each(0));
  const auto other = value(Face::create(face_parameters("v1"), Requests().sink()));
  ASSERT_TRUE(eventually([&] {
    other->heartbeat(State::idle);
    return !flags().empty() && flags().back() == kFlagAnotherDaemon;
  }));
}

TEST_F(Control, NobodyElseCanSayThatAHeartbeatIsOfAnotherDaemon) {
  lss_Command start = client_->command(kStart);
  start.flags = 0xFFFF;
  ASSERT_TRUE(client_->send(start));
  ASSERT_TRUE(eventually([&] { return !requests_.commands().empty(); }));
  EXPECT_EQ(requests_.commands().front().flags, kFlagDryRun);
}

TEST_F(Control, AnEmergencyStopOfEveryVehicleIsOursAndNoOtherCommandIs) {
  for (const std::uint16_t kind : {kStart, kEstop}) {
    lss_Command all = client_->command(kind);
    dds::copy_text(dds::kEveryVehicle, all.vehicle_id);
    ASSERT_TRUE(client_->send(all));
  }
  ASSERT_TRUE(eventually([&] { return !requests_.commands().empty(); }));
  EXPECT_EQ(requests_.commands().size(), 1u);
  EXPECT_EQ(requests_.commands().front().kind, kEstop);
}

TEST_F(Control, EveryWriterHasANumberOfItsOwnAndNamesDoNotMatter) {
  Client other(test_domain(), "v1", "client");
  ASSERT_TRUE(eventually([&] { return other.connected(); }));
  ASSERT_TRUE(client_->send(client_->command(kStart)));
  ASSERT_TRUE(eventually([&] { return requests_.commands().size() == 1; }));
  ASSERT_TRUE(client_->send(client_->command(kStart)));
  ASSERT_TRUE(eventually([&] { return requests_.commands().size() == 2; }));
  ASSERT_TRUE(other.send(other.command(kStart)));
  ASSERT_TRUE(eventually([&] { return requests_.commands().size() == 3; }));
  const auto writers = requests_.writers();
  EXPECT_EQ(writers[0], writers[1]);
  EXPECT_NE(writers[1], writers[2]);
}

TEST_F(Control, CommandsForAnotherVehicleAreIgnored) {
  lss_Command other = client_->command(kStart);
  dds::copy_text("v10", other.vehicle_id);
  ASSERT_TRUE(client_->send(other));
  lss_Command unterminated = client_->command(kStart);
  std::fill(std::begin(unterminated.vehicle_id), std::end(unterminated.vehicle_id), 'v');
  ASSERT_TRUE(client_->send(unterminated));
  lss_Command stop = client_->command(kEstop);
  dds::copy_text("v10", stop.vehicle_id);
  ASSERT_TRUE(client_->send(stop));
  lss_Command ours = client_->command(kEstop);
  ASSERT_TRUE(client_->send(ours));
  ASSERT_TRUE(eventually([&] { return !requests_.commands().empty(); }));
  EXPECT_EQ(requests_.commands().size(), 1u);
  EXPECT_EQ(requests_.commands().front().kind, kEstop);
}

TEST_F(Control, ABurstOfCommandsArrivesWholeAndInOrder) {
  constexpr std::uint64_t kBurst = 16;
  for (std::uint64_t i = 0; i < kBurst; ++i) ASSERT_TRUE(client_->send(client_->command(kStart)));
  ASSERT_TRUE(eventually([&] { return requests_.commands().size() == kBurst; }));
  const auto commands = requests_.commands();
  EXPECT_TRUE(std::is_sorted(commands.begin(), commands.end(),
                             [](auto& a, auto& b) { return a.sequence < b.sequence; }));
}

TEST_F(Control, StatusArrivesWithWhatTheFaceAddsToIt) {
  StatusReport report;
  report.state = State::operational;
  report.mode_name = "Walking";
  std::copy_n("cli", 3, report.authority.begin());
  report.faults[0] = {FaultId::module_silent, 3, 2, 77};
  report.fault_count = 1;
  report.time_ns = now_ns();
  report.threads[0].priority = 70;
  report.thread_count = 1;
  face_->status(report);
  ASSERT_TRUE(eventually([&] { return !client_->statuses().empty(); }));
  const lss_Status& status = client_->statuses().back();
  EXPECT_EQ(status.state, lss_STATE_OPERATIONAL);
  EXPECT_STREQ(status.vehicle, "zebro");
  EXPECT_STREQ(status.version, "0.1.0");
  EXPECT_STREQ(status.mode_name, "Walking");
  EXPECT_STREQ(status.authority, "cli");
  EXPECT_EQ(status.faults[0].id, static_cast<std::uint16_t>(FaultId::module_silent));
  EXPECT_EQ(status.faults[0].subject, 3);
  EXPECT_EQ(status.threads[0].priority, 70);
  EXPECT_EQ(status.shared_memory, lss_SHM_OFF);
  EXPECT_STREQ(status.shared_memory_text, "not configured");
  EXPECT_EQ(status.instance.pid, ::getpid());
  EXPECT_NE(status.instance.boot, 0u);
  EXPECT_GT(status.instance.started_utc_ns, 0);
  EXPECT_STRNE(status.instance.host, "");
  EXPECT_FALSE(status.airborne);
  EXPECT_EQ(status.stop_in_flight, lss_STOP_LANDS);
  EXPECT_NEAR(static_cast<double>(status.utc_ns), static_cast<double>(utc_ns()), 60e9);
}

TEST_F(Control, ALateClientGetsTheLastStatusAndTheLastEventsOfEachKind) {
  for (std::uint64_t i = 1; i <= 3; ++i) {
    StatusReport report;
    report.frame_index = i;
    face_->status(report);
  }
  const auto tell = [&](EventId id, std::uint16_t subject) {
    face_->event({.id = static_cast<std::uint16_t>(id), .subject = subject, .count = 7}, "text");
  };
  tell(EventId::port_closed, 0);  // the cause
  for (int i = 0; i < 2000; ++i)
    tell(EventId::module_was_reset, static_cast<std::uint16_t>(1 + i % 10));
  // A live client has every one of them.
  ASSERT_TRUE(eventually([&] { return client_->events().size() == 2001; }));
  Client late(test_domain(), "v1", "late");
  ASSERT_TRUE(eventually([&] { return late.events().size() == 1 + 10 * dds::kEventsKept; }));
  const auto cause = std::ranges::find(late.events(), 1u, &lss_Event::index);
  ASSERT_NE(cause, late.events().end());
  EXPECT_EQ(cause->id, static_cast<std::uint16_t>(EventId::port_closed));
  EXPECT_EQ(cause->count, 7u);
  const auto newest = std::ranges::max_element(late.events(), {}, &lss_Event::index);
  EXPECT_EQ(newest->index, 2001u);
  EXPECT_EQ(newest->number, 200u) << "of its kind and module";
  ASSERT_TRUE(eventually([&] { return !late.statuses().empty(); }));
  EXPECT_EQ(late.statuses().size(), 1u);
  EXPECT_EQ(late.statuses().front().frame_index, 3u);
}

// [O-Int-2]
TEST_F(Control, HeartbeatsOfTheDaemonCountUpAndCarryItsState) {
  ASSERT_TRUE(eventually([&] {
    face_->heartbeat(State::fatal_error);
    return client_->heartbeats().size() >= 2;
  }));
  const auto& beats = client_->heartbeats();
  EXPECT_STREQ(beats[0].source, "lssd");
  EXPECT_EQ(beats[0].state, lss_STATE_FATAL_ERROR);
  EXPECT_GT(beats[1].counter, beats[0].counter);
}

TEST_F(Control, TwoVehiclesShareADomain) {
  Requests other_requests;
  const auto other = value(Face::create(face_parameters("v2"), other_requests.sink()));
  Client other_client(test_domain(), "v2", "other");
  ASSERT_TRUE(eventually([&] { return other_client.connected(); }));
  ASSERT_TRUE(eventually(
      [&] { return client_->send(client_->command(kStart)) && !requests_.commands().empty(); }));
  ASSERT_TRUE(eventually([&] {
    return other_client.send(other_client.command(kEstop)) && !other_requests.commands().empty();
  }));
  for (const Request& request : requests_.commands()) {
    EXPECT_STREQ(request.source.data(), "client");
  }
  for (const Request& request : other_requests.commands()) {
    EXPECT_STREQ(request.source.data(), "other");
  }
}

// [Conf-1]
TEST_F(Control, ACommanderMadeFromTheIdlAloneIsHeardAndAnswered) {
  Child stranger({DDS_STRANGER, "command", std::to_string(test_domain()), "v1", "1", "20"},
                 loopback_uri(false));
  ASSERT_TRUE(eventually([&] { return !requests_.commands().empty(); }));
  std::size_t answered = 0;
  ASSERT_TRUE(eventually([&] {
    for (const auto commands = requests_.commands(); answered < commands.size(); ++answered) {
      const Request& request = commands[answered];
      face_->acknowledge({request.source,
                          request.sequence,
                          request.kind,
                          Phase::rejected,
                          {Reason::not_in_state, kRequired, kRequired, 0},
                          0});
    }
    return stranger.wait_for_line("phase", std::chrono::seconds(0));
  }));
  EXPECT_EQ(stranger.wait_for_exit(), 0);
  EXPECT_THAT(stranger.output(), testing::HasSubstr("phase 1 reason 12 rejected: not allowed"));
}

// The writer sends its command after its validity, as if the daemon had stood still.
TEST_F(Control, ACommandOlderThanItsLifespanIsNotObeyedButAnEmergencyStopIs) {
  const auto participant = value(dds::Participant::create({.domain = test_domain()}));
  const auto writer =
      value(dds::create_writer(participant.get(), dds::common_topic(dds::Kind::command)));
  ASSERT_TRUE(eventually([&] {
    dds_publication_matched_status_t status;
    return dds_get_publication_matched_status(writer.get(), &status) == DDS_RETCODE_OK &&
           status.current_count > 0;
  }));
  const dds_time_t old = dds_time() - DDS_SECS(3);
  const lss_Command stale = client_->command(kStart);
  const lss_Command estop = client_->command(kEstop);
  ASSERT_EQ(dds_write_ts(writer.get(), &stale, old), DDS_RETCODE_OK);
  ASSERT_EQ(dds_write_ts(writer.get(), &estop, old + 1), DDS_RETCODE_OK);
  ASSERT_TRUE(eventually([&] { return !requests_.commands().empty(); }));
  EXPECT_EQ(requests_.commands().size(), 1u);
  EXPECT_EQ(requests_.commands().front().kind, kEstop);
}

// [O-Int-3]
TEST_F(Control, TelemetryArrivesWithEveryModuleOfTheVehicle) {
  Child stranger({DDS_STRANGER, "telemetry", std::to_string(test_domain()), "3", "20"},
                 loopback_uri(false));
  const auto participant = value(dds::Participant::create({.domain = test_domain()}));
  const auto reader = value(dds::create_reader(
      participant.get(), dds::telemetry_topic("zebro", &lss_ZebroTelemetry_desc)));
  lss_ZebroTelemetry telemetry{};
  telemetry.frame = 9;
  telemetry.mode = static_cast<std::uint8_t>(zebro::Mode::walking);
  for (std::uint8_t i = 0; lss_ZebroModule & module : telemetry.modules) {
    module.position_rad = 0.5 * i;
    module.id = ++i;
  }
  lss_ZebroTelemetry sample{};
  void* pointer = &sample;
  dds_sample_info_t info{};
  ASSERT_TRUE(eventually([&] {
    face_->telemetry(&telemetry);
    return dds_take(reader.get(), &pointer, &info, 1, 1) == 1 && info.valid_data;
  }));
  EXPECT_STREQ(sample.vehicle_id, "v1");
  EXPECT_EQ(sample.frame, 9u);
  EXPECT_EQ(sample.mode, static_cast<std::uint8_t>(zebro::Mode::walking));
  EXPECT_EQ(sample.modules[6].id, 7);
  EXPECT_EQ(sample.modules[6].position_rad, 3.0);
  ASSERT_TRUE(eventually([&] {
    face_->telemetry(&telemetry);
    return stranger.wait_for_line("received 3", std::chrono::seconds(0));
  }));
}

TEST_F(Control, CommandsOfAnEarlierVersionDoNotArriveAndThatIsReportedOnce) {
  EXPECT_FALSE(face_->other_interface());
  dds_topic_descriptor_t earlier = earlier_Command_desc;
  earlier.m_typename = lss_Command_desc.m_typename;
  const auto participant = value(dds::Participant::create({.domain = test_domain()}));
  const auto writer =
      value(dds::create_writer(participant.get(), {dds::Kind::command, "lss/command", &earlier}));
  EXPECT_TRUE(eventually([&] { return face_->other_interface(); }));
  EXPECT_FALSE(face_->other_interface());
  dds_publication_matched_status_t matched{};
  ASSERT_EQ(dds_get_publication_matched_status(writer.get(), &matched), DDS_RETCODE_OK);
  EXPECT_EQ(matched.total_count, 0u);
}

TEST(FaceCreation, SaysWhatIsWrongWithItsParameters) {
  const auto error = [](const FaceParameters& parameters) {
    const auto face = Face::create(parameters, [](const Request&, std::uint64_t) {});
    return face ? std::string("created") : face.error().text;
  };
  FaceParameters parameters = face_parameters("a name that is too long");
  EXPECT_THAT(error(parameters), testing::HasSubstr("1 to 15 characters"));
  parameters = face_parameters("v1");
  parameters.vehicle = "snail";
  EXPECT_THAT(error(parameters), testing::HasSubstr("snail"));
  parameters = face_parameters("v1");
  parameters.domain = 4000;
  EXPECT_THAT(error(parameters), testing::HasSubstr("out of range"));
  const auto without =
      dds::Participant::create({.domain = test_domain(), .interfaces = {"no-such-link"}});
  ASSERT_FALSE(without) << "only a daemon goes on without it";
  EXPECT_THAT(without.error().text, testing::HasSubstr("bring up no-such-link"));
  EXPECT_EQ(without.error().cure, Cure::time) << "it can come up";
}

TEST(FaceCreation, SaysThatCycloneddsUriIsWrong) {
  ::setenv("CYCLONEDDS_URI", "file:///no-such-file", 1);
  const auto face = Face::create(face_parameters("v1"), [](const Request&, std::uint64_t) {});
  ::unsetenv("CYCLONEDDS_URI");
  ASSERT_FALSE(face);
  EXPECT_THAT(face.error().text, testing::HasSubstr("correct or unset CYCLONEDDS_URI"));
  EXPECT_EQ(face.error().cure, Cure::time) << "an interface that it names can come up";
}

}  // namespace
}  // namespace lss
