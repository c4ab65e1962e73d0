#pragma once

// docs/faults-zebro.md: its text around the rows, and rows compared with those in the file. The
// tests make the rows; run with LSS_WRITE_FAULTS=1 in the environment, all of them in one program,
// they write the document. Measurements are not compared: it is rounded, and another processor may
// round otherwise. Throws nothing; errors are sentences.

#include <string>

namespace lss::zebro {

// Empty when the row with this number is in the document, except for measurements; else what to do.
// When writing: keeps the row, always empty.
std::string check_row(std::size_t number, const std::string& row);

// Empty when the document has the text around the table and no other rows than so many.
std::string check_frame(std::size_t rows);

// Whether rows are kept to be written; and writes them.
bool writing_faults();
void write_faults();

}  // namespace lss::zebro
