// The sentences of acknowledgements, made from the numbered lists.

#include <fmt/format.h>

#include <cmath>

#include "daemon/dds/convert.h"

namespace lss::dds {
namespace {

constexpr const char* kPhaseNames[] = {"accepted",  "rejected", "executing",
                                       "completed", "failed",   "superseded"};

std::string number(double value) { return fmt::format("{:.6g}", value); }

// Names the module, wheel or node in the place where the text speaks of "a module" or "module".
std::string with_subject(std::string text, std::uint16_t subject,
                         std::span<const char* const> modules) {
  if (subject == 0) return text;
  const std::string named = subject <= modules.size()
                                ? fmt::format("{} ({})", subject, modules[subject - 1u])
                                : fmt::format("{}", subject);
  for (const std::string_view word : {"module", "leg", "wheel", "node"}) {
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
  return text + fmt::format(", module {}", named);
}

bool of_parameter(Reason reason) {
  return reason == Reason::parameter_range || reason == Reason::parameter_whole ||
         reason == Reason::parameter_together;
}

// What is wrong with the value, and what would be right.
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
  const std::size_t subject = ack.verdict.subject;
  if (of_parameter(ack.verdict.reason) && subject >= 1 && subject <= subjects.tunables.size()) {
    text += ": " + parameter_text(ack.verdict, *reason, subjects.tunables[subject - 1]);
    return text + fmt::format("; {}", reason->advice);
  }
  text += ": " + with_subject(reason->text, ack.verdict.subject, subjects.modules);
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
