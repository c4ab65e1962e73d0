// Rows of CSV, for all types of files.

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "tools/lss-cli/verbs/log_files.h"

namespace lss::cli {
namespace {

using Write = std::function<std::uint64_t(std::FILE*)>;

Failure not_opened(const std::string& path) {
  return Failure(ExitCode::usage, fmt::format("{}: {}", path, std::strerror(errno)),
                 "name a file in a folder that you may write to");
}

// A file becomes another one when that is complete; a device or a link is written to.
std::uint64_t to_file(const std::string& path, const Write& write) {
  recording::refuse_recording(path);
  std::error_code ignored;
  const std::filesystem::file_type type = std::filesystem::symlink_status(path, ignored).type();
  const bool exists = type == std::filesystem::file_type::regular;
  bool replaces = exists || type == std::filesystem::file_type::not_found;
  struct stat old {};
  if (exists && (access(path.c_str(), W_OK) != 0 || stat(path.c_str(), &old) != 0))
    throw not_opened(path);
  std::string written = fmt::format("{}.{}.part", path, getpid());
  std::FILE* file = replaces ? std::fopen(written.c_str(), "wx") : nullptr;
  if (file == nullptr) {  // or its folder takes no other file
    replaces = false;
    written = path;
    file = std::fopen(path.c_str(), "w");
  }
  if (file == nullptr) throw not_opened(path);
  if (exists && replaces) {
    fchmod(fileno(file), old.st_mode & 07777);
    [[maybe_unused]] const int only_by_root = fchown(fileno(file), old.st_uid, old.st_gid);
  }
  std::uint64_t rows = 0;
  try {
    rows = write(file);
  } catch (...) {
    std::fclose(file);
    if (replaces) std::remove(written.c_str());
    throw;
  }
  const bool failed = std::ferror(file) != 0;
  if (std::fclose(file) != 0 || failed) {
    if (replaces) std::remove(written.c_str());
    throw Failure(ExitCode::failed, path + " cannot be written", "is the disk full?");
  }
  if (replaces && std::rename(written.c_str(), path.c_str()) != 0) {
    const int error = errno;
    std::remove(written.c_str());
    errno = error;
    throw not_opened(path);
  }
  return rows;
}

}  // namespace

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_value(const nlohmann::ordered_json& value) {
  if (value.is_null()) return "";
  if (value.is_boolean()) return value.get<bool>() ? "1" : "0";
  return value.is_string() ? csv_text(value.get<std::string>()) : value.dump();
}

ExitCode export_rows(Context& context, const LogWanted& wanted, const char* of_what,
                     const Write& write) {
  if (wanted.out.empty()) {
    if (context.output.machine()) {
      throw Failure(ExitCode::usage, "the rows and the document would both go to stdout",
                    "name a file by --out");
    }
    write(stdout);
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      throw Failure(ExitCode::failed,
                    fmt::format("stdout does not take all {}: {}", of_what, std::strerror(errno)),
                    "is the disk full?");
    }
    return ExitCode::completed;
  }
  const std::uint64_t rows = to_file(wanted.out, write);
  context.output.print(fmt::format("{}: {} {}\n", wanted.out, rows, of_what));
  context.output.document({{"path", wanted.path}, {"out", wanted.out}, {of_what, rows}});
  return ExitCode::completed;
}

}  // namespace lss::cli
