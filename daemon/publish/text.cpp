// The sentences of acknowledgements, made from the numbered lists.

#include <fmt/format.h>

#include <cmath>

#include "daemon/cycle/common_commands.h"
#include "daemon/cycle/subjects.h"
#include "daemon/publish/convert.h"

namespace lss::dds {
namespace {

constexpr const char* kPhaseNames[] = {"accepted",  "rejected", "executing",
                                       "completed", "failed",   "superseded"};

std::string number(double value) { return fmt::format("{:.6g}", value); }

// Inserts the name of the subject: "a module" becomes "module 3 (LM)". Without such a place the
// first of the words names it at the end.
std::string with_name(std::string text, std::span<const std::string_view> words,
                      const std::string& named) {
  for (const std::string_view word : words) {
    const std::size_t at = text.find(word);
    const std::size_t end = at + word.size();
    const bool is_word = at != std::string::npos &&
                         (end == text.size() || text[end] == ' ' || text[end] == ',') &&
                         (at == 0 || text[at - 1] == ' ');
    if (!is_word) continue;
    text.insert(end, " " + named);
    if (at >= 2 && text.compare(at - 2, 2, "a ") == 0) text.erase(at - 2, 2);
    return text;
  }
  return text + fmt::format(", {} {}", words.front(), named);
}

std::string with_module(const std::string& text, std::size_t number,
                        std::span<const char* const> modules) {
  static constexpr std::string_view kWords[] = {"module", "leg", "wheel", "node"};
  return with_name(text, kWords,
                   number <= modules.size() ? fmt::format("{} ({})", number, modules[number - 1])
                                            : fmt::format("{}", number));
}

// A parameter of the command by its name, or by its number when the command does not have it.
std::string with_parameter(const std::string& text, std::size_t number,
                           const CommandInfo* command) {
  static constexpr std::string_view kWords[] = {"parameter"};
  const bool known = command != nullptr && number <= command->parameters.size();
  return with_name(text, kWords,
                   known ? command->parameters[number - 1].name : fmt::format("{}", number));
}

// The step of a script.
std::string with_step(const std::string& text, std::size_t number) {
  static constexpr std::string_view kWords[] = {"step"};
  return with_name(text, kWords, fmt::format("{}", number));
}

std::string with_subject(const Ack& ack, const CodeInfo& reason, const Subjects& subjects) {
  const std::size_t number = ack.verdict.subject;
  if (number == 0) return reason.text;
  switch (subject_is(ack.verdict.reason)) {
    case SubjectIs::argument:
      return with_parameter(reason.text, number, find_command(subjects.commands, ack.kind));
    case SubjectIs::step: return with_step(reason.text, number);
    default: return with_module(reason.text, number, subjects.modules);
  }
}

// The value, its error and its range.
std::string parameter_text(const Verdict& verdict, const CodeInfo& reason, const TunableInfo& t) {
  const std::string unit = *t.unit != '\0' ? fmt::format(" {}", t.unit) : "";
  const std::string value = fmt::format("{}: {}{}", t.name, number(verdict.measured), unit);
  if (verdict.reason != Reason::parameter_range) return fmt::format("{}: {}", value, reason.text);
  return fmt::format("{} is out of range, allowed {} to {}{}", value, number(t.min), number(t.max),
                     unit);
}

}  // namespace

std::string ack_text(const Ack& ack, const Subjects& subjects) {
  std::string text = kPhaseNames[static_cast<std::size_t>(ack.phase)];
  const CodeInfo* reason = info(ack.verdict.reason);
  if (ack.verdict.reason == Reason::none) return text;
  if (reason == nullptr) {
    return text + fmt::format(": reason {}", static_cast<unsigned>(ack.verdict.reason));
  }
  if (ack.verdict.reason == Reason::no_such_parameter && !subjects.name.empty())
    return text + fmt::format(": there is no parameter '{}'; {}", subjects.name, reason->advice);
  const std::size_t subject = ack.verdict.subject;
  if (subject_is(ack.verdict.reason) == SubjectIs::tunable && subject >= 1 &&
      subject <= subjects.tunables.size()) {
    text += ": " + parameter_text(ack.verdict, *reason, subjects.tunables[subject - 1]);
    return text + fmt::format("; {}", reason->advice);
  }
  text += ": " + with_subject(ack, *reason, subjects);
  const bool measured = !std::isnan(ack.verdict.measured);
  const bool limited = !std::isnan(ack.verdict.limit);
  if (measured && limited) {
    text += fmt::format(" (measured {}, allowed {})", number(ack.verdict.measured),
                        number(ack.verdict.limit));
  } else if (measured) {
    text += fmt::format(" (measured {})", number(ack.verdict.measured));
  } else if (limited) {
    text += fmt::format(" (allowed {})", number(ack.verdict.limit));
  }
  if (*reason->advice != '\0') text += fmt::format("; {}", reason->advice);
  return text;
}

}  // namespace lss::dds
