#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "daemon/runtime/clock.h"
#include "idl/other_daemons.h"
#include "idl/topics.h"
#include "tests/bench/programs.h"

namespace lss::bench {

inline constexpr auto kFleetLimit = std::chrono::seconds(60);

// A client that reads the status of all vehicles.
class StatusReader {
 public:
  explicit StatusReader(int domain) : began_ns_(now_ns()) {
    auto participant = dds::Participant::create({.domain = domain});
    if (!participant) throw NotHere(participant.error().text);
    participant_.emplace(std::move(*participant));
    auto reader = dds::create_reader(participant_->get(), dds::common_topic(dds::Kind::status));
    if (!reader) throw NotHere(reader.error());
    reader_ = std::move(*reader);
  }

  // From the client's first call of DDS.
  double all_heard_s(std::size_t vehicles) {
    std::set<std::string> heard;
    const auto all = [&] {
      lss_Status sample;
      void* pointer = &sample;
      dds_sample_info_t info;
      while (dds_take(reader_.get(), &pointer, &info, 1, 1) > 0) {
        if (info.valid_data) heard.insert(sample.vehicle_id);
      }
      return heard.size() == vehicles;
    };
    if (!eventually(all, kFleetLimit))
      throw std::runtime_error(fmt::format("a client heard {} of {} vehicles within {} s",
                                           heard.size(), vehicles, kFleetLimit.count()));
    return static_cast<double>(now_ns() - began_ns_) * 1e-9;
  }

  // Each daemon knows all others, by the user data of its participant.
  void wait_until_all_know_each_other(std::size_t vehicles) {
    const dds::Entity reader(dds_create_reader(
        participant_->get(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr));
    std::map<dds::Guid, unsigned> others;
    const auto all_do = [&] {
      dds::take_participants(
          reader.get(),
          [&](const dds::Guid& guid, const std::optional<unsigned>& known) {
            if (known) others[guid] = *known;
          },
          [&](const dds::Guid& guid) { others.erase(guid); });
      return others.size() == vehicles &&
             std::ranges::all_of(others, [&](const auto& o) { return o.second + 1 == vehicles; });
    };
    if (!eventually(all_do, kFleetLimit))
      throw std::runtime_error(fmt::format("{} vehicles do not know each other within {} s",
                                           vehicles, kFleetLimit.count()));
  }

 private:
  TimeNs began_ns_;
  std::optional<dds::Participant> participant_;
  dds::Entity reader_;
};

}  // namespace lss::bench
