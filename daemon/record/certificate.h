#pragma once

// A timing certificate (docs/timing.md): how late a frame of this program may be on this machine,
// kernel and configuration, as lss-cli timing certify found. The daemon compares each frame with
// it, on the publish thread: the real-time threads do nothing for it.

#include <filesystem>
#include <string>
#include <tl/expected.hpp>

#include "daemon/cycle/messages.h"

namespace lss::record {

// What a certificate is valid for; in its file by these names.
struct CertifiedOn {
  std::string machine;        // the model of the CPU
  std::string kernel;         // release, version and architecture
  std::string version;        // of lssd, with its build ID
  std::string configuration;  // CRC-32C of its values without [timing], hexadecimal
};

struct Certificate {
  CertifiedOn on;
  TimeNs ready_ns = 0;    // frame boundary to the command being ready
  TimeNs release_ns = 0;  // T_k + offset to the command being handed to the bus
};

// Of this machine. `config`: the text of a configuration that was read without an error.
CertifiedOn certified_here(const std::string& version, const std::string& config);

// The error is a sentence with the file's name.
tl::expected<Certificate, std::string> read_certificate(const std::filesystem::path& file);
// A sentence for each of the four that differs; empty: it is valid here.
std::string not_valid(const CertifiedOn& made, const CertifiedOn& here);

// Compares frames, one after the other, with a certificate. A release is reported with the frame
// after it; of missing frames it is not known.
class CertificateWatch {
 public:
  explicit CertificateWatch(const Certificate& certificate) noexcept : allowed_(certificate) {}

  // report(EventRecord) for each time above what is certified.
  template <class Report>
  void look(const TimingPoints& t, Report&& report) {
    const auto exceeded = [&](EventId id, std::uint64_t frame, TimeNs at_ns, TimeNs took_ns,
                              TimeNs allowed_ns) {
      if (took_ns <= allowed_ns) return;
      report(EventRecord{
          .time_ns = at_ns,
          .severity = Severity::warning,
          .id = static_cast<std::uint16_t>(id),
          .argument = {static_cast<double>(frame), static_cast<double>(took_ns) / kMicrosecond,
                       static_cast<double>(allowed_ns) / kMicrosecond}});
    };
    if (before_.frame != 0 && before_.frame + 1 == t.frame) {
      exceeded(EventId::release_uncertified, before_.frame, t.released_ns,
               t.released_ns - before_.boundary_ns - before_.offset_ns, allowed_.release_ns);
    }
    exceeded(EventId::ready_uncertified, t.frame, t.ready_ns, t.ready_ns - t.boundary_ns,
             allowed_.ready_ns);
    before_ = t;
  }

 private:
  Certificate allowed_;
  TimingPoints before_{};
};

}  // namespace lss::record
