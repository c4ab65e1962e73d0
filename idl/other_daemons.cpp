#include "idl/other_daemons.h"

#include <algorithm>
#include <charconv>
#include <string>

namespace lss::dds {

std::optional<unsigned> others_known(const dds_qos_t* participant) {
  void* data = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(participant, &data, &size) || data == nullptr) return std::nullopt;
  const std::string text(static_cast<const char*>(data), size);
  dds_free(data);
  if (!text.starts_with(kDaemonMark)) return std::nullopt;
  if (text.size() == kDaemonMark.size()) return 0;
  unsigned others = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data() + kDaemonMark.size() + 1, end, others);
  if (text[kDaemonMark.size()] != ' ' || error != std::errc() || rest != end) return std::nullopt;
  return std::min(others, kMostOthers);
}

OtherDaemons::OtherDaemons(const Participant& participant) : participant_(participant.get()) {
  if (participant.enclave()) return;
  dds_guid_t self{};
  if (dds_get_guid(participant_, &self) != DDS_RETCODE_OK) return;
  self_ = std::to_array(self.v);
  reader_ =
      Entity(dds_create_reader(participant_, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, nullptr));
}

void OtherDaemons::look() {
  if (!reader_) return;
  const unsigned before = count();
  take_participants(
      reader_.get(),
      [&](const Guid& guid, const std::optional<unsigned>& others) {
        if (others && guid != self_) found_.insert(guid);
      },
      [&](const Guid& guid) { found_.erase(guid); });
  if (count() == before) return;
  std::string mark(kDaemonMark);
  if (count() > 0) mark += ' ' + std::to_string(count());
  dds_qos_t* qos = dds_create_qos();
  dds_qset_userdata(qos, mark.data(), mark.size());
  dds_set_qos(participant_, qos);  // fails only without memory: then clients listen as before
  dds_delete_qos(qos);
}

}  // namespace lss::dds
