#pragma once

// The verb `serve`, of the program only.

namespace lss::cli {

class Grammar;

void add_serve_verb(Grammar& grammar);

}  // namespace lss::cli
