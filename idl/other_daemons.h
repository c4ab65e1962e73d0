#pragma once

// How daemons of one domain let a client know that the first one it receives is not the only one:
// each says in the user data of its participant how many others it knows of.

#include <dds/dds.h>

#include <array>
#include <optional>
#include <set>

#include "idl/topics.h"

namespace lss::dds {

// Of a participant: how many other daemons it knows of; empty: it is no daemon. User data are
// kDaemonMark, and the number behind it unless it is 0. Anybody can write them: at most
// kMostOthers.
inline constexpr unsigned kMostOthers = 1000;
std::optional<unsigned> others_known(const dds_qos_t* participant);

// Takes what DDS has found, of a reader of its built-in topic of participants: calls
// heard(guid, others) for each, `others` as above, and gone(guid).
template <class Heard, class Gone>
void take_participants(dds_entity_t reader, Heard&& heard, Gone&& gone) {
  void* samples[1] = {nullptr};
  dds_sample_info_t info{};
  while (dds_take(reader, samples, &info, 1, 1) == 1) {
    const auto& found = *static_cast<const dds_builtintopic_participant_t*>(samples[0]);
    const Guid guid = std::to_array(found.key.v);
    if (info.instance_state != DDS_IST_ALIVE) {
      gone(guid);
    } else if (info.valid_data) {
      heard(guid, others_known(found.qos));
    }
    dds_return_loan(reader, samples, 1);
    samples[0] = nullptr;
  }
}

// The other daemons of a domain, for a daemon. Not with DDS Security, where anybody could set the
// mark. Ordinary threads; one at a time.
class OtherDaemons {
 public:
  // The participant must outlive it.
  explicit OtherDaemons(const Participant& participant);

  // Takes what DDS has found since the last call, and says it in the user data when the number
  // changed. A daemon that was killed counts until its lease ends, 10 s.
  void look();
  unsigned count() const { return static_cast<unsigned>(found_.size()); }

 private:
  dds_entity_t participant_;
  Guid self_{};
  Entity reader_;
  std::set<Guid> found_;
};

}  // namespace lss::dds
