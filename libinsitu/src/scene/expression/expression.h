#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "scene/expression/reduction.h"

namespace insitu::scene {

/// What is wrong with an expression, and where: `column` counts the expression's bytes from 1.
struct ExpressionError : std::runtime_error {
  ExpressionError(std::size_t column_, const std::string& message)
      : std::runtime_error(message), column(column_) {}
  std::size_t column;
};

/// A condition such as `max(pressure) > 2.0 and not cycle < 100`, parsed once and evaluated every
/// cycle.
///
///   condition := and-part { ("or" | "||") and-part }
///   and-part  := not-part { ("and" | "&&") not-part }
///   not-part  := ("not" | "!") not-part | comparison
///   comparison:= sum [ ("<" | "<=" | ">" | ">=" | "==" | "!=") sum ]
///   sum       := product { ("+" | "-") product }
///   product   := factor { ("*" | "/") factor }
///   factor    := ("+" | "-") factor | number | "cycle" | "time" | "abs" "(" sum ")" | reduction |
///   "(" condition ")" reduction := ("min" | "max" | "mean") "(" field ")"
///
/// A field is a name of letters, digits, "_", "." and ":", or any text within single or double
/// quotes. Conditions and numbers do not mix, so `max(pressure)` alone or `1 < 2 < 3` is refused.
/// Comparisons follow IEEE 754: with a NaN (the reduction of a field without values) all are false
/// but "!=".
class Expression {
public:
  struct FieldUse {
    Reduction reduction;
    std::string field;
    friend bool operator==(const FieldUse&, const FieldUse&) = default;
  };
  /// Returns the reduction of the field at this step. Called at most once per evaluation for each
  /// FieldUse that decides the answer: `and` and `or` evaluate from left to right and stop as soon
  /// as the answer is known, the same way on every rank whose reductions agree, so it may be a
  /// collective call.
  using Reduce = std::function<double(Reduction, const std::string& field)>;

  /// What fields stand for: reductions over the mesh, or values at a point. At a point a field's
  /// name stands alone (quoted if it is one of the words), and "age" is a number.
  enum class Scope : std::uint8_t { mesh, point };

  /// Parses; throws ExpressionError.
  explicit Expression(std::string_view text, Scope scope = Scope::mesh);
  /// Parses; throws core::Error(INSITU_ERROR_SCENE) with "file:line: ...", the column and a caret
  /// under it.
  static Expression parse(std::string_view text, std::string_view file, int line);

  const std::string& text() const { return text_; }
  /// What must exist before evaluate(): each reduction of each field once, in the order of the
  /// text.
  const std::vector<FieldUse>& uses() const { return uses_; }
  bool evaluate(std::int64_t cycle, double time, const Reduce& reduce) const;
  /// The same at a point; values are those of uses(), in their order.
  bool evaluate_at(std::int64_t cycle, double time, double age,
                   const std::vector<double>& values) const;

private:
  friend class ExpressionParser;
  enum class Kind : std::uint8_t {
    number,
    cycle,
    time,
    age,
    reduction, // leaves
    negate,
    absolute,
    add,
    subtract,
    multiply,
    divide, // number -> number
    less,
    less_equal,
    greater,
    greater_equal,
    equal,
    not_equal, // number -> condition
    logical_and,
    logical_or,
    logical_not // condition -> condition
  };
  struct Node {
    Kind kind;
    double value = 0;      // number
    std::size_t left = 0;  // node; reduction: index into uses_
    std::size_t right = 0; // node
    int depth = 1;         // of the tree below, this node included
  };
  class Evaluation;

  std::string text_;
  Scope scope_ = Scope::mesh;
  std::vector<FieldUse> uses_;
  std::vector<Node> nodes_; // children before parents: the last is the root
};

/// The message of an expression error with the expression and a caret below the column:
///   "'>' is followed by nothing (column 17)\n    max(pressure) >\n                   ^"
std::string describe(const ExpressionError& error, std::string_view text);

} // namespace insitu::scene
