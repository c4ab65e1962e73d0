#pragma once

// Output for people and programs: results on stdout, diagnostics and progress on stderr. One object
// per run of lss-cli; main thread only. Colours only on a terminal, without NO_COLOR and
// --no-color.

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/options.h"

namespace lss::cli {

inline constexpr int kSchemaVersion = 2;

// Colours of text, or none.
struct Style {
  bool colour = false;

  std::string bold(std::string_view text) const { return paint("1", text); }
  std::string dim(std::string_view text) const { return paint("2", text); }
  std::string good(std::string_view text) const { return paint("32", text); }
  std::string warning(std::string_view text) const { return paint("33", text); }
  std::string bad(std::string_view text) const { return paint("1;31", text); }

 private:
  std::string paint(std::string_view code, std::string_view text) const;
};

// The beginning of a screen that fits a terminal of so many rows and columns: longer lines are cut,
// colours end with their line, and a last line says how many rows are missing.
std::string fitted(std::string_view screen, unsigned rows, unsigned columns);

class Output {
 public:
  explicit Output(const Options& options);
  ~Output() { end_progress(); }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  const Style& style() const { return style_; }  // of stdout
  bool machine() const { return json_ || jsonl_; }
  bool stream() const { return jsonl_; }
  bool terminal() const { return terminal_; }  // stdout is a terminal, and people read it

  // For people, on stdout; nothing with --json and --jsonl. The text includes its line ends.
  void print(std::string_view text);
  // For programs. --json: the document of this run, written by finish(); --jsonl: a line, at once.
  void document(nlohmann::json document);
  // --jsonl only: a line, at once.
  void record(nlohmann::json record);

  // On stderr.
  void note(std::string_view text);
  void fail(const Failure& failure);
  // A line on stderr that is overwritten in place; nothing when stderr is no terminal.
  void progress(std::string_view text);
  void end_progress();

  // Ends the run. A verb without a document gets one with its result; several are merged into one.
  void finish(ExitCode code, const Failure* failure, nlohmann::json commands);

 private:
  void emit(const nlohmann::json& document, bool indented);

  bool json_, jsonl_;
  bool terminal_, live_;
  bool progressing_ = false;
  Style style_, diagnostics_;  // of stdout, of stderr
  std::vector<nlohmann::json> documents_;
};

}  // namespace lss::cli
