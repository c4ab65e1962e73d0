#pragma once

// A recording of messages, independent of its format: its topics, and their messages in order. MCAP
// is one format; another format is another class behind open(). One thread. Errors in a file are
// thrown as a Failure that names it.

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/recording/idl_types.h"
#include "tools/lss-cli/recording/mcap_format.h"

namespace lss::cli::recording {

struct Topic {
  std::string name;       // lss/status
  std::string type_name;  // lss::Status
  std::string encoding;   // of its schema and of its messages: "omgidl, cdr"
  Span span;
  std::uint64_t gaps = 0;          // missing messages, by their counter
  const Layout* layout = nullptr;  // nullptr: its messages cannot be decoded
};

struct Message {
  const Topic& topic;
  std::uint32_t sequence;
  std::int64_t log_ns, publish_ns;  // UTC
  Bytes data;
};

// The selection. Times in seconds since the first message of the file.
struct Filter {
  std::vector<std::string> topics;  // as typed by the user; empty: all
  double from_s = -std::numeric_limits<double>::infinity();
  double until_s = std::numeric_limits<double>::infinity();
};

class Recording {
 public:
  virtual ~Recording() = default;
  virtual const char* kind() const = 0;
  virtual const std::vector<Topic>& topics() const = 0;
  virtual const Span& span() const = 0;
  virtual const Texts& about() const = 0;             // vehicle, vehicle_id, version, ...
  std::string about(const std::string& what) const {  // "?": unknown
    const auto found = about().find(what);
    return found == about().end() ? "?" : found->second;
  }
  virtual const std::string& complaint() const = 0;  // empty: the file is whole
  // In the order of the file.
  virtual void each(const Filter& filter,
                    const std::function<void(const Message&)>& take) const = 0;
  // The same as a file of this type.
  virtual std::uint64_t copy(const Filter& filter, const std::string& path) const = 0;

  double seconds(std::int64_t ns) const { return ns_between(span().first_ns, ns) / 1e9; }
};

// By its first bytes.
std::unique_ptr<Recording> open(const std::string& path);
bool is_recording(const std::string& path);
bool begins_with(const std::string& path, Bytes magic);  // false unless a regular file

// "telemetry", "lss/telemetry/zebro" and "lss/tele*" are lss/telemetry/zebro.
bool names(std::string_view wanted, std::string_view topic);
// `*` matches any text.
bool matches(std::string_view pattern, std::string_view text);
// The topics that the filter selects, in the order of the file; throws unknown_name when there is
// none.
std::vector<const Topic*> select(const Recording& recording, const Filter& filter);

// The field that counts the messages of a topic, which shows gaps; nullptr when there is none.
const Column* counter_of(const Layout& layout);

}  // namespace lss::cli::recording
