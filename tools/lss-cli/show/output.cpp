#include "tools/lss-cli/show/output.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

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

void write(std::FILE* file, std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), file);
  std::fflush(file);
}

}  // namespace

std::string Style::paint(std::string_view code, std::string_view text) const {
  return colour ? fmt::format("\x1b[{}m{}\x1b[0m", code, text) : std::string(text);
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

void Output::document(nlohmann::json document) {
  document["schema_version"] = kSchemaVersion;
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
