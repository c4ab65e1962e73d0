#include "tools/lss-cli/show/output.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace lss::cli {
namespace {

bool colour_allowed(const Options& options) {
  const char* no_color = std::getenv("NO_COLOR");
  return !options.no_color && (no_color == nullptr || *no_color == '\0');
}

// A line wider than the terminal would wrap and could not be overwritten.
std::string fit_terminal(std::string_view text) {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col < 20) return std::string(text);
  return std::string(text.substr(0, size.ws_col - 1u));
}

// Escape sequences take no column; a character of UTF-8 takes one.
std::string first_columns(std::string_view line, unsigned columns) {
  std::string cut;
  unsigned taken = 0;
  bool escape = false;
  for (const char c : line) {
    const bool continues = (static_cast<unsigned char>(c) & 0xc0u) == 0x80u;
    if (c == '\x1b') escape = true;
    if (!escape && !continues && ++taken > columns) break;
    cut += c;
    if (escape && c == 'm') escape = false;
  }
  if (taken > columns && cut.find('\x1b') != std::string::npos) cut += "\x1b[0m";
  return cut;
}

void write(std::FILE* file, std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), file);
  std::fflush(file);
}

}  // namespace

std::string Style::paint(std::string_view code, std::string_view text) const {
  return colour ? fmt::format("\x1b[{}m{}\x1b[0m", code, text) : std::string(text);
}

std::string fitted(std::string_view screen, unsigned rows, unsigned columns) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin <= screen.size();) {
    const std::size_t end = std::min(screen.find('\n', begin), screen.size());
    lines.push_back(first_columns(screen.substr(begin, end - begin), columns));
    begin = end + 1;
  }
  if (lines.size() > rows) {
    const std::size_t missing = lines.size() - rows + 1;
    lines.resize(rows);
    lines.back() = first_columns(
        fmt::format("... {} more lines: make the window higher, or: lss-cli status", missing),
        columns);
  }
  return fmt::format("{}", fmt::join(lines, "\n"));
}

Output::Output(const Options& options)
    : json_(options.json),
      jsonl_(options.jsonl),
      terminal_(isatty(STDOUT_FILENO) == 1 && !options.machine()),
      live_(isatty(STDERR_FILENO) == 1),
      style_{terminal_ && colour_allowed(options)},
      diagnostics_{live_ && colour_allowed(options)} {}

void Output::print(std::string_view text) {
  if (machine()) return;
  end_progress();
  write(stdout, text);
}

// A dictionary has a version of its own.
void Output::document(nlohmann::json document) {
  document.emplace("schema_version", kSchemaVersion);
  if (jsonl_) {
    emit(document, false);
  } else if (json_) {
    documents_.push_back(std::move(document));
  }
}

void Output::record(nlohmann::json record) {
  if (!jsonl_) return;
  record["schema_version"] = kSchemaVersion;
  emit(record, false);
}

void Output::note(std::string_view text) {
  end_progress();
  write(stderr, fmt::format("{}\n", text));
}

void Output::fail(const Failure& failure) {
  note(fmt::format("{} {}", diagnostics_.bad("lss-cli:"), failure.what()));
  if (!failure.advice().empty()) note("  -> " + failure.advice());
}

void Output::progress(std::string_view text) {
  if (!live_) return;
  write(stderr, "\r\x1b[K" + fit_terminal(text));
  progressing_ = true;
}

void Output::end_progress() {
  if (!progressing_) return;
  write(stderr, "\r\x1b[K");
  progressing_ = false;
}

void Output::finish(ExitCode code, const Failure* failure, nlohmann::json commands) {
  end_progress();
  if (!machine()) return;
  nlohmann::json end = {{"exit_code", static_cast<int>(code)}, {"error", nullptr}};
  if (failure != nullptr) end["error"] = {{"text", failure->what()}, {"advice", failure->advice()}};
  const bool commanded = !commands.empty();
  if (jsonl_) {
    if (commanded || failure != nullptr) document(std::move(end));
  } else if (documents_.size() == 1 && !commanded && failure == nullptr) {
    emit(documents_.front(), true);
  } else {
    end["schema_version"] = kSchemaVersion;
    end["commands"] = std::move(commands);
    if (!documents_.empty()) end["documents"] = std::move(documents_);
    emit(end, true);
  }
  documents_.clear();
}

void Output::emit(const nlohmann::json& document, bool indented) {
  // Text of other programs may contain invalid UTF-8.
  write(stdout,
        document.dump(indented ? 2 : -1, ' ', false, nlohmann::json::error_handler_t::replace) +
            "\n");
}

}  // namespace lss::cli
