#pragma once

// A configuration as text, before it is parsed, with limits, so that no file exhausts the program
// that reads it: the parser recurses for each part of a dotted key, without a limit.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace lss::config {

// Limits of a configuration; the shipped ones are far below.
namespace most {
inline constexpr std::size_t kBytes = 256'000;
inline constexpr std::size_t kKeyParts = 16;  // of a dotted key
inline constexpr std::size_t kText = 1000;    // characters of a text
inline constexpr std::size_t kTables = 100;   // in a list of tables, and texts in a list
inline constexpr std::size_t kGuess = 64;     // characters of a word for which another is suggested
}  // namespace most

// Why the text must not be parsed; nothing when it can be.
std::optional<std::string> too_much(std::string_view text);

// An error in one line, which no byte of the file that it quotes can break or make a command of a
// terminal: control characters become blanks.
std::string one_line(std::string error);

// The text of a file when it can be parsed; an error is a sentence without the file's name.
tl::expected<std::string, std::string> read_document(const std::filesystem::path& file);

}  // namespace lss::config
