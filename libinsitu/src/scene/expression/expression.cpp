#include "scene/expression/expression.h"

#include <cmath>
#include <optional>

#include "core/status.h"
#include "scene/expression/expression_text.h"

namespace insitu::scene {
namespace {

constexpr std::size_t shown_width = 100; // of a long expression in a message

} // namespace

/// One evaluation: recursive, to the depth that the parser has limited.
class Expression::Evaluation {
public:
  Evaluation(const Expression& expression, std::int64_t cycle, double time, const Reduce& reduce)
      : expression_(expression), cycle_(static_cast<double>(cycle)), time_(time), reduce_(reduce),
        reduced_(expression.uses_.size()) {}

  /// At a point, where all values are known.
  Evaluation(const Expression& expression, std::int64_t cycle, double time, double age,
             const Reduce& none, const std::vector<double>& values)
      : expression_(expression), cycle_(static_cast<double>(cycle)), time_(time), age_(age),
        reduce_(none), reduced_(values.begin(), values.end()) {}

  bool condition(std::size_t index) {
    const Node& node = expression_.nodes_[index];
    switch (node.kind) {
    case Kind::logical_and:
      return condition(node.left) && condition(node.right);
    case Kind::logical_or:
      return condition(node.left) || condition(node.right);
    case Kind::logical_not:
      return !condition(node.left);
    default:
      break;
    }
    const double left = number(node.left);
    const double right = number(node.right);
    switch (node.kind) {
    case Kind::less:
      return left < right;
    case Kind::less_equal:
      return left <= right;
    case Kind::greater:
      return left > right;
    case Kind::greater_equal:
      return left >= right;
    case Kind::equal:
      return left == right;
    default:
      return left != right;
    }
  }

private:
  double number(std::size_t index) {
    const Node& node = expression_.nodes_[index];
    switch (node.kind) {
    case Kind::number:
      return node.value;
    case Kind::cycle:
      return cycle_;
    case Kind::time:
      return time_;
    case Kind::age:
      return age_;
    case Kind::reduction:
      return reduction(node.left);
    case Kind::negate:
      return -number(node.left);
    case Kind::absolute:
      return std::abs(number(node.left));
    default:
      break;
    }
    const double left = number(node.left);
    const double right = number(node.right);
    switch (node.kind) {
    case Kind::add:
      return left + right;
    case Kind::subtract:
      return left - right;
    case Kind::multiply:
      return left * right;
    default:
      return left / right;
    }
  }

  double reduction(std::size_t use) {
    if (!reduced_[use])
      reduced_[use] = reduce_(expression_.uses_[use].reduction, expression_.uses_[use].field);
    return *reduced_[use];
  }

  const Expression& expression_;
  double cycle_;
  double time_;
  double age_ = 0;
  const Reduce& reduce_;
  std::vector<std::optional<double>> reduced_;
};

bool Expression::evaluate(std::int64_t cycle, double time, const Reduce& reduce) const {
  return Evaluation(*this, cycle, time, reduce).condition(nodes_.size() - 1);
}

bool Expression::evaluate_at(std::int64_t cycle, double time, double age,
                             const std::vector<double>& values) const {
  const Reduce none;
  return Evaluation(*this, cycle, time, age, none, values).condition(nodes_.size() - 1);
}

std::string describe(const ExpressionError& error, std::string_view text) {
  std::size_t at = error.column - 1;
  std::string message =
      std::string(error.what()) + " (column " + std::to_string(error.column) + " of the condition)";
  // A window around the column, so that one problem never fills a screen.
  if (text.size() > shown_width) {
    std::size_t first = at > shown_width / 2 ? at - shown_width / 2 : 0;
    while (first > 0 && first < text.size() && continues_letter(text[first]))
      --first;
    text = text.substr(first, shown_width);
    at -= first;
  }
  std::string shown, below;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    shown += c < 0x20 || c == 0x7F ? ' ' : text[i];
    if (i < at && !continues_letter(text[i]))
      below += ' ';
  }
  return message + "\n    " + shown + "\n    " + below + "^";
}

Expression Expression::parse(std::string_view text, std::string_view file, int line) {
  try {
    return Expression(text);
  } catch (const ExpressionError& error) {
    throw core::Error(INSITU_ERROR_SCENE, std::string(file) + ":" + std::to_string(line) + ": " +
                                              describe(error, text));
  }
}

} // namespace insitu::scene
