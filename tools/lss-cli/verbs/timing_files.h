#pragma once

// timing trace and timing certify: the actions of timing that need no daemon. Main thread.

#include <optional>
#include <string>
#include <vector>

#include "tools/lss-cli/verbs/log_files.h"

namespace lss::cli {

// Writes the frames of a flight recording (wanted.path) as a trace that ui.perfetto.dev and
// chrome://tracing open, to wanted.out or stdout: the JSON of Google's "Trace Event Format". Times
// are those of CLOCK_MONOTONIC.
ExitCode timing_trace(Context& context, const LogWanted& wanted);

struct CertifyWanted {
  std::string config;
  std::vector<std::string> recordings;
  std::string lssd;         // the program that is certified; empty: beside this one
  std::size_t frames = 16;  // of each recording, whose instructions are counted
  int seconds = 60;         // of measuring the kernel
  std::optional<double> latency_us = std::nullopt;  // measured before, by another tool
  std::string out;  // empty: the file that the configuration names, or none
};

// Prints the bound on the lateness of a frame's orders on this machine, and writes the certificate
// that lssd compares its frames with (daemon/record/certificate.h).
ExitCode timing_certify(Context& context, const CertifyWanted& wanted);

}  // namespace lss::cli
