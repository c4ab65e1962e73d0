#pragma once

// What the fuzzers have in common (docs/fuzzing.md). Each source of this folder is one of
// libFuzzer: bytes in, no output; what must hold is checked with must(), the sanitizers check the
// rest.

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace lss::fuzz {

using Bytes = std::span<const std::uint8_t>;

inline void must(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

inline std::string text_of(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Numbers and bytes from the input, in its order; zeros after its end.
class Input {
 public:
  explicit Input(Bytes bytes) : left_(bytes) {}

  template <class T>
  T number() {
    T value{};
    const Bytes bytes = take(sizeof value);
    std::memcpy(&value, bytes.data(), bytes.size());
    return value;
  }
  std::uint8_t byte() { return number<std::uint8_t>(); }
  std::uint8_t below(unsigned end) { return static_cast<std::uint8_t>(byte() % end); }
  // As many as there are, at most.
  Bytes take(std::size_t count) {
    const Bytes bytes = left_.first(std::min(count, left_.size()));
    left_ = left_.subspan(bytes.size());
    return bytes;
  }
  bool empty() const { return left_.empty(); }
  Bytes rest() { return take(left_.size()); }

 private:
  Bytes left_;
};

// A file in a folder of this process, for what reads files by name. Gone at the end.
class File {
 public:
  explicit File(const char* suffix) {
    if (::mkdtemp(folder_.data()) == nullptr) std::abort();
    path_ = folder_ + "/input" + suffix;
  }
  ~File() {
    ::unlink(path_.c_str());
    ::rmdir(folder_.c_str());
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  const std::string& path() const { return path_; }
  void write(Bytes bytes) const {
    std::FILE* file = std::fopen(path_.c_str(), "wb");
    if (file == nullptr || std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size())
      std::abort();
    std::fclose(file);
  }

 private:
  std::string folder_ = "/dev/shm/lss-fuzz-XXXXXX", path_;
};

}  // namespace lss::fuzz
