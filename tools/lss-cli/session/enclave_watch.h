#pragma once

// Warnings of the enclave of a program that does not end by itself, on stderr: at its start, and
// as lssd of the expiry: from 30 days before once a day, and when it has expired. One thread.

#include <fmt/format.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <utility>

#include "daemon/runtime/expiry_watch.h"
#include "idl/topics.h"

namespace lss::cli {

class EnclaveWatch {
 public:
  EnclaveWatch(std::string program, const dds::Participant& participant)
      : program_(std::move(program)) {
    for (const std::string& warning : participant.warnings()) warn(warning);
    if (const auto& enclave = participant.enclave()) {
      folder_ = enclave->folder.string();
      expiry_ = ExpiryWatch(enclave->not_after_utc_s);
    }
    expiry_.look(std::time(nullptr));  // among the warnings
  }

  // Call often.
  void look() {
    const auto left_s = expiry_.look(std::time(nullptr));
    if (!left_s) return;
    const std::int64_t days = std::abs(*left_s) / ExpiryWatch::kDay_s;
    warn(*left_s < 0 ? fmt::format("{} expired {} days ago: make a new one, without it {} does not "
                                   "start again",
                                   folder_, days, program_)
                     : fmt::format("{} expires in {} days: make a new one before, and restart {}",
                                   folder_, days, program_));
  }

 private:
  void warn(const std::string& text) const {
    fmt::print(stderr, "{}: warning: {}\n", program_, text);
  }

  std::string program_, folder_;
  ExpiryWatch expiry_;
};

}  // namespace lss::cli
