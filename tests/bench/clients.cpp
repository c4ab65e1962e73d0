#include "tests/bench/clients.h"

#include <cstring>

#include "daemon/runtime/clock.h"
#include "idl/commands.h"

namespace lss::bench {

Pinger::Pinger(int domain, const std::filesystem::path& enclave)
    : participant_(value(dds::Participant::create({.domain = domain, .enclave = enclave}))),
      listener_(dds_create_listener(this)),
      writer_(
          value(dds::create_writer(participant_.get(), dds::common_topic(dds::Kind::command)))) {
  dds_lset_data_available(listener_, [](dds_entity_t reader, void* self) {
    static_cast<Pinger*>(self)->heard(reader);
  });
  reader_ = value(dds::create_reader(participant_.get(), dds::common_topic(dds::Kind::command_ack),
                                     dds::Transport::best, listener_));
  std::strcpy(command_.vehicle_id, "zebro-1");
  std::strcpy(command_.source, kPilot);
  command_.kind = static_cast<std::uint16_t>(CommandKind::request_data);
  command_.flags = kFlagDryRun;
  // Messages sent before both ends are matched are not answered.
  if (!eventually([this] { return !times_us(1).empty(); }))
    throw NotHere("nobody acknowledges commands: is loopback up, and multicast allowed on it?");
}

Pinger::~Pinger() {
  reader_.reset();
  dds_delete_listener(listener_);
}

Samples Pinger::times_us(int count) {
  times_us_.clear();
  times_us_.reserve(static_cast<std::size_t>(count));
  left_ = count;
  send();
  if (!over_.try_acquire_for(std::chrono::milliseconds(200 + count))) left_ = 0;
  return times_us_;
}

void Pinger::send() {
  ++command_.seq;
  sent_ns_ = now_ns();
  dds_write(writer_.get(), &command_);
}

void Pinger::heard(dds_entity_t reader) {
  void* pointer = &ack_;
  dds_sample_info_t info;
  while (dds_take(reader, &pointer, &info, 1, 1) > 0) {
    const TimeNs now = now_ns();
    if (!info.valid_data || ack_.seq != command_.seq || left_ == 0) continue;
    times_us_.push_back(static_cast<double>(now - sent_ns_) * 1e-3);
    if (--left_ > 0) {
      send();
    } else {
      over_.release();
    }
  }
}

Samples call_ms(const std::vector<std::string>& words,
                const std::pair<std::string, std::string>& variable, int count) {
  Folder folder;
  Samples times;
  for (int i = 0; i < count; ++i) {
    Process call(words, folder / "call.log", {variable});
    if (const int code = call.wait(); code != 0)
      throw std::runtime_error(words.front() + " failed: " + read_file(folder / "call.log"));
    times.push_back(static_cast<double>(now_ns() - call.started_ns()) * 1e-6);
  }
  return times;
}

std::vector<std::string> stop_dry_run(int domain) {
  return {program("lss-cli"), "--domain", std::to_string(domain), "--vehicle", "zebro-1", "stop",
          "--dry-run"};
}

lss_Status status_after(int domain, std::uint64_t frames) {
  const auto participant = dds::Participant::create({.domain = domain});
  if (!participant) throw NotHere(participant.error().text);
  const auto reader = dds::create_reader(participant->get(), dds::common_topic(dds::Kind::status));
  if (!reader) throw NotHere(reader.error());
  lss_Status status{};
  const auto ran = [&] {
    lss_Status sample;
    void* pointer = &sample;
    dds_sample_info_t info;
    while (dds_take(reader->get(), &pointer, &info, 1, 1) > 0) {
      if (info.valid_data) status = sample;
    }
    return status.frame_index >= frames;
  };
  if (!eventually(ran, std::chrono::seconds(60)))
    throw std::runtime_error("the daemon says no status");
  return status;
}

std::filesystem::path make_keystore(const std::filesystem::path& folder) {
  const std::string keys = folder / "keys", cli = program("lss-cli");
  for (const std::vector<std::string>& words : {std::vector<std::string>{"create", keys},
                                                {"add", keys, "zebro-1", "--role", "vehicle"},
                                                {"add", keys, kPilot, "--role", "command"}}) {
    std::vector<std::string> line{cli, "keystore"};
    line.insert(line.end(), words.begin(), words.end());
    Process call(line, folder / "keys.log");
    if (call.wait() != 0) throw NotHere(read_file(folder / "keys.log"));
  }
  return folder / "keys/enclaves";
}

}  // namespace lss::bench
