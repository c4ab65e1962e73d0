#pragma once

// A document of measurements, one section at a time: the tests that measure write theirs.

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace lss::testing_support {

// Replaces the section `title` (## in the file), or adds it at the end; `text` ends with a newline.
// A file that is empty or missing begins with `beginning`.
inline void write_section(const std::string& file, const std::string& title,
                          const std::string& text, const std::string& beginning = "") {
  std::stringstream old;
  old << std::ifstream(file).rdbuf();
  std::string document = old.str().empty() ? beginning : old.str();
  const std::string head = "\n## " + title + "\n";
  const std::size_t begin = document.find(head);
  if (begin != std::string::npos) {
    const std::size_t end = document.find("\n## ", begin + head.size());
    document.replace(begin, end == std::string::npos ? end : end - begin, head + text);
  } else {
    document += head + text;
  }
  std::ofstream(file + ".next") << document;
  std::filesystem::rename(file + ".next", file);
}

}  // namespace lss::testing_support
