#include "daemon/record/files.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <ctime>
#include <system_error>

#include "daemon/record/limits.h"
#include "drivers/file.h"
#include "drivers/time.h"

namespace lss::record {

namespace fs = std::filesystem;

fs::path NumberedFiles::path(unsigned number, std::int64_t utc_ns, std::string_view what) const {
  const auto utc_s = static_cast<std::time_t>(utc_ns / kSecond);
  return folder_ / fmt::format("{}{:06}-{:%Y%m%dT%H%M%S}Z-{}{}", prefix_, number,
                               fmt::gmtime(utc_s), what, suffix_);
}

unsigned NumberedFiles::number_of(const fs::path& path) const {
  const std::string name = path.filename().string();
  constexpr std::size_t kDigits = 6, kMostDigits = 9;
  if (!name.starts_with(prefix_) || !name.ends_with(suffix_)) return 0;
  const std::string_view rest = std::string_view(name).substr(prefix_.size());
  const std::size_t digits = rest.find_first_not_of("0123456789");
  if (digits == std::string_view::npos || digits < kDigits || digits > kMostDigits ||
      rest[digits] != '-')
    return 0;
  unsigned number = 0;
  std::from_chars(rest.data(), rest.data() + digits, number);
  return number;
}

std::vector<std::pair<unsigned, fs::path>> NumberedFiles::list() const {
  std::vector<std::pair<unsigned, fs::path>> files;
  for (fs::path& path : entries(folder_)) {
    if (const unsigned number = number_of(path); number != 0)
      files.emplace_back(number, std::move(path));
  }
  std::ranges::sort(files);
  return files;
}

unsigned NumberedFiles::make_room(std::uint64_t bytes, std::uint64_t total) const {
  const auto files = list();
  std::error_code ignored;
  for (auto file = files.rbegin(); file != files.rend(); ++file) {
    const std::uintmax_t size = fs::file_size(file->second, ignored);
    if (!ignored) bytes += size;
    if (bytes <= total) continue;
    const File old(::open(file->second.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (!old || !is_being_written(old.get())) fs::remove(file->second, ignored);
  }
  return files.empty() ? 1 : files.back().first + 1;
}

std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error))
    found.push_back(at->path());
  return found;
}

std::string line_of(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

namespace {

// The parser itself has no limit, and copies and destroys recursively.
bool nests_too_deep(std::string_view json) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_text) {
      if (c == '\\') ++i;
      in_text = c != '"';
    } else if (c == '"') {
      in_text = true;
    } else if (c == '{' || c == '[') {
      if (++depth > most::kJsonDepth) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

}  // namespace

nlohmann::ordered_json parse_json(std::string_view text) {
  using Json = nlohmann::ordered_json;
  return nests_too_deep(text) ? Json(Json::value_t::discarded) : Json::parse(text, nullptr, false);
}

void mark_being_written(int fd) { ::flock(fd, LOCK_EX | LOCK_NB); }

bool is_being_written(int fd) {
  if (::flock(fd, LOCK_SH | LOCK_NB) != 0) return errno == EWOULDBLOCK;
  ::flock(fd, LOCK_UN);
  return false;
}

bool is_removed(int fd) {
  struct stat info {};
  return ::fstat(fd, &info) == 0 && info.st_nlink == 0;
}

int write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(fd, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

}  // namespace lss::record
