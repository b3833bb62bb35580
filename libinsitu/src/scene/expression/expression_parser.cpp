#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/suggest.h"
#include "scene/expression/expression.h"
#include "scene/expression/expression_text.h"
#include "scene/parse/problems.h"

namespace insitu::scene {
namespace {

constexpr std::size_t longest_expression = 4096; // bytes
constexpr int deepest_expression = 64;           // nested parentheses, signs and negations
constexpr int deepest_tree = 1024;               // and length of a chain such as 1 + 1 + 1 + ...

const std::vector<std::string> words = {"min",  "max", "mean", "abs", "cycle",
                                        "time", "and", "or",   "not"};

} // namespace

/// Recursive descent over the text; each parse_ function returns the index of the node that it
/// appended last.
class ExpressionParser {
public:
  ExpressionParser(Expression& out) : out_(out), text_(out.text_) {}

  void parse() {
    if (text_.size() > longest_expression) {
      throw ExpressionError(1, "the condition has " + std::to_string(text_.size()) +
                                   " bytes, more than " + std::to_string(longest_expression));
    }
    text_.start();
    if (text_.is_at_end())
      text_.fail("the condition is empty");
    const std::size_t root = parse_or();
    text_.start();
    if (!text_.is_at_end()) {
      text_.fail(text_.is_comparison() ? "comparisons cannot be chained; join two of them by 'and'"
                                       : "unexpected " + text_.here());
    }
    require_condition(root, 0);
  }

private:
  using Kind = Expression::Kind;

  /// Counts the nesting of the descent itself.
  struct Depth {
    explicit Depth(ExpressionParser& parser) : parser_(parser) {
      if (++parser_.depth_ > deepest_expression) {
        parser_.text_.fail("more than " + std::to_string(deepest_expression) +
                           " levels of nesting");
      }
    }
    ~Depth() { --parser_.depth_; }
    ExpressionParser& parser_;
  };

  bool is_condition(std::size_t node) const { return out_.nodes_[node].kind >= Kind::less; }

  void require_condition(std::size_t node, std::size_t start) const {
    if (!is_condition(node))
      text_.fail("a condition expected, a number found; compare it with something", start);
  }
  void require_number(std::size_t node, std::size_t start) const {
    if (is_condition(node))
      text_.fail("a number expected, a condition found", start);
  }

  std::size_t append(Expression::Node node) {
    if (node.depth > deepest_tree)
      text_.fail("more than " + std::to_string(deepest_tree) + " terms in a row");
    out_.nodes_.push_back(node);
    return out_.nodes_.size() - 1;
  }
  std::size_t append_unary(Kind kind, std::size_t operand) {
    return append({kind, 0, operand, operand, out_.nodes_[operand].depth + 1});
  }
  std::size_t append_binary(Kind kind, std::size_t left, std::size_t right) {
    const int depth = std::max(out_.nodes_[left].depth, out_.nodes_[right].depth) + 1;
    return append({kind, 0, left, right, depth});
  }

  std::size_t parse_or() {
    const std::size_t first = text_.start();
    std::size_t left = parse_and();
    while (text_.accept_word("or") || text_.accept("||")) {
      require_condition(left, first);
      const std::size_t second = text_.start();
      const std::size_t right = parse_and();
      require_condition(right, second);
      left = append_binary(Kind::logical_or, left, right);
    }
    return left;
  }

  std::size_t parse_and() {
    const std::size_t first = text_.start();
    std::size_t left = parse_not();
    while (text_.accept_word("and") || text_.accept("&&")) {
      require_condition(left, first);
      const std::size_t second = text_.start();
      const std::size_t right = parse_not();
      require_condition(right, second);
      left = append_binary(Kind::logical_and, left, right);
    }
    return left;
  }

  std::size_t parse_not() {
    if (text_.accept_word("not") || text_.accept("!")) {
      const Depth depth(*this);
      const std::size_t first = text_.start();
      const std::size_t operand = parse_not();
      require_condition(operand, first);
      return append_unary(Kind::logical_not, operand);
    }
    return parse_comparison();
  }

  std::size_t parse_comparison() {
    const std::size_t first = text_.start();
    const std::size_t left = parse_sum();
    text_.start();
    static constexpr std::pair<std::string_view, Kind> symbols[] = {
        {"<=", Kind::less_equal}, {">=", Kind::greater_equal}, {"==", Kind::equal},
        {"!=", Kind::not_equal},  {"<", Kind::less},           {">", Kind::greater}};
    for (const auto& [symbol, kind] : symbols) {
      if (text_.accept(symbol)) {
        require_number(left, first);
        const std::size_t second = text_.start();
        const std::size_t right = parse_sum();
        require_number(right, second);
        return append_binary(kind, left, right);
      }
    }
    if (text_.next() == '=')
      text_.fail("'=' is not a comparison; write '=='");
    return left;
  }

  std::size_t parse_sum() {
    const std::size_t first = text_.start();
    std::size_t left = parse_product();
    for (;;) {
      const bool plus = text_.accept("+");
      if (!plus && !text_.accept("-"))
        return left;
      require_number(left, first);
      const std::size_t second = text_.start();
      const std::size_t right = parse_product();
      require_number(right, second);
      left = append_binary(plus ? Kind::add : Kind::subtract, left, right);
    }
  }

  std::size_t parse_product() {
    const std::size_t first = text_.start();
    std::size_t left = parse_factor();
    for (;;) {
      const bool times = text_.accept("*");
      if (!times && !text_.accept("/"))
        return left;
      require_number(left, first);
      const std::size_t second = text_.start();
      const std::size_t right = parse_factor();
      require_number(right, second);
      left = append_binary(times ? Kind::multiply : Kind::divide, left, right);
    }
  }

  std::size_t parse_factor() {
    const Depth depth(*this);
    const std::size_t first = text_.start();
    const bool minus = text_.accept("-");
    if (minus || text_.accept("+")) {
      const std::size_t second = text_.start();
      const std::size_t operand = parse_factor();
      require_number(operand, second);
      return minus ? append_unary(Kind::negate, operand) : operand;
    }
    if (text_.accept("(")) {
      const std::size_t inside = parse_or();
      text_.expect(")", "at the end of the parenthesis");
      return inside;
    }
    if (text_.is_number())
      return append({Kind::number, text_.number()});
    if (text_.accept_word("cycle"))
      return append({Kind::cycle});
    if (text_.accept_word("time"))
      return append({Kind::time});
    if (text_.accept_word("abs")) {
      text_.expect("(", "after 'abs'");
      const std::size_t second = text_.start();
      const std::size_t operand = parse_or();
      require_number(operand, second);
      text_.expect(")", "after the value of 'abs'");
      return append_unary(Kind::absolute, operand);
    }
    if (out_.scope_ == Expression::Scope::point)
      return parse_field_at_point(first);
    for (const Reduction reduction : {Reduction::min, Reduction::max, Reduction::mean})
      if (text_.accept_word(reduction_name(reduction)))
        return parse_reduction(reduction);
    fail_at_operand(first);
  }

  /// `age`, or the name of a field.
  std::size_t parse_field_at_point(std::size_t first) {
    if (text_.accept_word("age"))
      return append({Kind::age});
    if (!text_.is_letter_at(first) && !text_.is_quote_at(first))
      text_.fail("a value expected, " + text_.here() + " found");
    const std::string field = text_.field_name("");
    text_.start();
    if (text_.next() == '(') {
      text_.fail(quote(field) +
                     " is no function here: at a point a field is its value there, and stands "
                     "alone",
                 first);
    }
    if (std::find(words.begin(), words.end(), field) != words.end() && text_.is_letter_at(first)) {
      text_.fail("a value expected, " + quote(field) + " found; a field of this name is quoted",
                 first);
    }
    return append_use({Reduction::value, field});
  }

  std::size_t append_use(const Expression::FieldUse& use) {
    const auto found = std::find(out_.uses_.begin(), out_.uses_.end(), use);
    const auto index = static_cast<std::size_t>(found - out_.uses_.begin());
    if (found == out_.uses_.end())
      out_.uses_.push_back(use);
    return append({Kind::reduction, 0, index});
  }

  [[noreturn]] void fail_at_operand(std::size_t first) const {
    if (text_.is_letter_at(first)) {
      const std::string_view word = text_.name_at(first);
      const std::string near = core::did_you_mean(word, words);
      if (text_.byte_at(first + word.size()) == '(') {
        text_.fail("the function " + quote(word) + " is unknown" + near +
                   " (functions: min, max, mean, abs)");
      }
      if (std::find(words.begin(), words.end(), word) == words.end()) {
        text_.fail("the name " + quote(word) + " is unknown" + near +
                   "; a field is used as min(field), max(field) or mean(field)");
      }
    }
    text_.fail("a value expected, " + text_.here() + " found");
  }

  std::size_t parse_reduction(Reduction reduction) {
    const std::string name = reduction_name(reduction);
    text_.expect("(", "after '" + name + "'");
    text_.start();
    const std::string field = text_.field_name(" in " + name + "(...)");
    if (!text_.accept(")")) {
      text_.fail("')' expected after the field's name, " + text_.here() + " found; " + name +
                 " takes one field, and a name with other letters than A-Z, a-z, 0-9, '_', '.', "
                 "':' is quoted");
    }
    return append_use({reduction, field});
  }

  Expression& out_;
  ExpressionText text_;
  int depth_ = 0;
};

Expression::Expression(std::string_view text, Scope scope) : text_(text), scope_(scope) {
  ExpressionParser(*this).parse();
}

} // namespace insitu::scene
