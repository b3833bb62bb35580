#include "scene/expression/trigger.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/status.h"
#include "core/suggest.h"
#include "scene/parse/problems.h"

namespace insitu::scene {
namespace {

constexpr std::size_t longest_expression = 4096; // bytes
constexpr int deepest_expression = 64;           // nested parentheses, signs and negations
constexpr int deepest_tree = 1024;               // and length of a chain such as 1 + 1 + 1 + ...

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_name(char c) {
  return is_letter(c) || is_digit(c) || c == '.' || c == ':';
}

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
    skip_space();
    if (at_ == text_.size()) {
      fail("the condition is empty");
    }
    const std::size_t root = parse_or();
    skip_space();
    if (at_ != text_.size()) {
      fail(is_comparison() ? "comparisons cannot be chained; join two of them by 'and'"
                           : "unexpected " + here());
    }
    require_condition(root, 0);
  }

private:
  using Kind = Expression::Kind;

  /// Counts the nesting of the descent itself.
  struct Depth {
    explicit Depth(ExpressionParser& parser) : parser_(parser) {
      if (++parser_.depth_ > deepest_expression) {
        parser_.fail("more than " + std::to_string(deepest_expression) + " levels of nesting");
      }
    }
    ~Depth() { --parser_.depth_; }
    ExpressionParser& parser_;
  };

  [[noreturn]] void fail(const std::string& message) const { fail(message, at_); }
  [[noreturn]] void fail(const std::string& message, std::size_t at) const {
    throw ExpressionError(at + 1, message);
  }

  void skip_space() {
    while (at_ < text_.size() &&
           (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r')) {
      ++at_;
    }
  }

  /// What stands at the current position, for messages.
  std::string here() const {
    if (at_ >= text_.size()) {
      return "end of the condition";
    }
    std::size_t end = at_ + 1;
    if (is_name(text_[at_])) {
      while (end < text_.size() && is_name(text_[end])) {
        ++end;
      }
    } else {
      while (end < text_.size() && (static_cast<unsigned char>(text_[end]) & 0xC0) == 0x80) {
        ++end; // the rest of a UTF-8 letter
      }
    }
    return quote(text_.substr(at_, end - at_));
  }

  bool accept(std::string_view symbol) {
    skip_space();
    if (text_.substr(at_, symbol.size()) != symbol) {
      return false;
    }
    at_ += symbol.size();
    return true;
  }

  /// Accepts a whole word: "or" is not the beginning of "order".
  bool accept_word(std::string_view word) {
    skip_space();
    if (text_.substr(at_, word.size()) != word ||
        (at_ + word.size() < text_.size() && is_name(text_[at_ + word.size()]))) {
      return false;
    }
    at_ += word.size();
    return true;
  }

  void expect(std::string_view symbol, const std::string& after) {
    if (!accept(symbol)) {
      fail("'" + std::string(symbol) + "' expected " + after + ", " + here() + " found");
    }
  }

  bool is_comparison() const {
    const char c = at_ < text_.size() ? text_[at_] : '\0';
    return c == '<' || c == '>' || c == '=' || (c == '!' && text_.substr(at_, 2) == "!=");
  }

  bool is_condition(std::size_t node) const { return out_.nodes_[node].kind >= Kind::less; }

  void require_condition(std::size_t node, std::size_t start) const {
    if (!is_condition(node)) {
      fail("a condition expected, a number found; compare it with something", start);
    }
  }
  void require_number(std::size_t node, std::size_t start) const {
    if (is_condition(node)) {
      fail("a number expected, a condition found", start);
    }
  }

  std::size_t append(Expression::Node node) {
    if (node.depth > deepest_tree) {
      fail("more than " + std::to_string(deepest_tree) + " terms in a row");
    }
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

  /// Where the next operand begins, for messages about it.
  std::size_t start() {
    skip_space();
    return at_;
  }

  std::size_t parse_or() {
    const std::size_t first = start();
    std::size_t left = parse_and();
    while (accept_word("or") || accept("||")) {
      require_condition(left, first);
      const std::size_t second = start();
      const std::size_t right = parse_and();
      require_condition(right, second);
      left = append_binary(Kind::logical_or, left, right);
    }
    return left;
  }

  std::size_t parse_and() {
    const std::size_t first = start();
    std::size_t left = parse_not();
    while (accept_word("and") || accept("&&")) {
      require_condition(left, first);
      const std::size_t second = start();
      const std::size_t right = parse_not();
      require_condition(right, second);
      left = append_binary(Kind::logical_and, left, right);
    }
    return left;
  }

  std::size_t parse_not() {
    if (accept_word("not") || accept("!")) {
      const Depth depth(*this);
      const std::size_t first = start();
      const std::size_t operand = parse_not();
      require_condition(operand, first);
      return append_unary(Kind::logical_not, operand);
    }
    return parse_comparison();
  }

  std::size_t parse_comparison() {
    const std::size_t first = start();
    const std::size_t left = parse_sum();
    skip_space();
    static constexpr std::pair<std::string_view, Kind> symbols[] = {
        {"<=", Kind::less_equal}, {">=", Kind::greater_equal}, {"==", Kind::equal},
        {"!=", Kind::not_equal},  {"<", Kind::less},           {">", Kind::greater}};
    for (const auto& [symbol, kind] : symbols) {
      if (accept(symbol)) {
        require_number(left, first);
        const std::size_t second = start();
        const std::size_t right = parse_sum();
        require_number(right, second);
        return append_binary(kind, left, right);
      }
    }
    if (at_ < text_.size() && text_[at_] == '=') {
      fail("'=' is not a comparison; write '=='");
    }
    return left;
  }

  std::size_t parse_sum() {
    const std::size_t first = start();
    std::size_t left = parse_product();
    for (;;) {
      const bool plus = accept("+");
      if (!plus && !accept("-")) {
        return left;
      }
      require_number(left, first);
      const std::size_t second = start();
      const std::size_t right = parse_product();
      require_number(right, second);
      left = append_binary(plus ? Kind::add : Kind::subtract, left, right);
    }
  }

  std::size_t parse_product() {
    const std::size_t first = start();
    std::size_t left = parse_factor();
    for (;;) {
      const bool times = accept("*");
      if (!times && !accept("/")) {
        return left;
      }
      require_number(left, first);
      const std::size_t second = start();
      const std::size_t right = parse_factor();
      require_number(right, second);
      left = append_binary(times ? Kind::multiply : Kind::divide, left, right);
    }
  }

  std::size_t parse_factor() {
    const Depth depth(*this);
    const std::size_t first = start();
    if (accept("-") || accept("+")) {
      const bool minus = text_[at_ - 1] == '-';
      const std::size_t second = start();
      const std::size_t operand = parse_factor();
      require_number(operand, second);
      return minus ? append_unary(Kind::negate, operand) : operand;
    }
    if (accept("(")) {
      const std::size_t inside = parse_or();
      expect(")", "at the end of the parenthesis");
      return inside;
    }
    if (at_ < text_.size() && (is_digit(text_[at_]) || text_[at_] == '.')) {
      return parse_number();
    }
    if (accept_word("cycle")) {
      return append({Kind::cycle});
    }
    if (accept_word("time")) {
      return append({Kind::time});
    }
    if (accept_word("abs")) {
      expect("(", "after 'abs'");
      const std::size_t second = start();
      const std::size_t operand = parse_or();
      require_number(operand, second);
      expect(")", "after the value of 'abs'");
      return append_unary(Kind::absolute, operand);
    }
    if (out_.scope_ == Expression::Scope::point) {
      return parse_field_at_point(first);
    }
    for (const Reduction reduction : {Reduction::min, Reduction::max, Reduction::mean}) {
      if (accept_word(reduction_name(reduction))) {
        return parse_reduction(reduction);
      }
    }
    fail_at_operand(first);
  }

  /// `age`, or the name of a field.
  std::size_t parse_field_at_point(std::size_t first) {
    if (accept_word("age")) {
      return append({Kind::age});
    }
    if (first >= text_.size() ||
        (!is_letter(text_[first]) && text_[first] != '"' && text_[first] != '\'')) {
      fail("a value expected, " + here() + " found");
    }
    const std::string field = parse_field_name("");
    skip_space();
    if (at_ < text_.size() && text_[at_] == '(') {
      fail(quote(field) + " is no function here: at a point a field is its value there, and stands "
                          "alone",
           first);
    }
    if (std::find(words.begin(), words.end(), field) != words.end() && is_letter(text_[first])) {
      fail("a value expected, " + quote(field) + " found; a field of this name is quoted", first);
    }
    return append_use({Reduction::value, field});
  }

  std::size_t append_use(const Expression::FieldUse& use) {
    const auto found = std::find(out_.uses_.begin(), out_.uses_.end(), use);
    const auto index = static_cast<std::size_t>(found - out_.uses_.begin());
    if (found == out_.uses_.end()) {
      out_.uses_.push_back(use);
    }
    return append({Kind::reduction, 0, index});
  }

  /// A name as it is or within quotes; `in` is where, for messages.
  std::string parse_field_name(const std::string& in) {
    std::string field;
    const std::size_t first = at_;
    if (at_ < text_.size() && (text_[at_] == '"' || text_[at_] == '\'')) {
      const std::size_t close = text_.find(text_[at_], at_ + 1);
      if (close == std::string_view::npos) {
        fail("the quotation mark is not closed");
      }
      field = text_.substr(at_ + 1, close - at_ - 1);
      at_ = close + 1;
    } else {
      while (at_ < text_.size() && is_name(text_[at_])) {
        ++at_;
      }
      field = text_.substr(first, at_ - first);
    }
    if (field.empty()) {
      fail("the name of a field expected" + in + ", " + here() + " found", first);
    }
    return field;
  }

  [[noreturn]] void fail_at_operand(std::size_t first) const {
    if (first < text_.size() && is_letter(text_[first])) {
      std::size_t end = first;
      while (end < text_.size() && is_name(text_[end])) {
        ++end;
      }
      const std::string_view word = text_.substr(first, end - first);
      const std::string near = core::did_you_mean(word, words);
      if (end < text_.size() && text_[end] == '(') {
        fail("the function " + quote(word) + " is unknown" + near +
             " (functions: min, max, mean, abs)");
      }
      if (std::find(words.begin(), words.end(), word) == words.end()) {
        fail("the name " + quote(word) + " is unknown" + near +
             "; a field is used as min(field), max(field) or mean(field)");
      }
    }
    fail("a value expected, " + here() + " found");
  }

  std::size_t parse_number() {
    const char* begin = text_.data() + at_;
    double value = 0;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error != std::errc() || !std::isfinite(value)) {
      fail(here() + " is not a finite number");
    }
    const std::size_t start_at = at_;
    at_ += static_cast<std::size_t>(end - begin);
    if (at_ < text_.size() && is_name(text_[at_])) {
      at_ = start_at;
      fail(here() + " is not a number");
    }
    return append({Kind::number, value});
  }

  std::size_t parse_reduction(Reduction reduction) {
    const std::string name = reduction_name(reduction);
    expect("(", "after '" + name + "'");
    skip_space();
    const std::string field = parse_field_name(" in " + name + "(...)");
    skip_space();
    if (at_ >= text_.size() || text_[at_] != ')') {
      fail("')' expected after the field's name, " + here() + " found; " + name +
           " takes one field, and a name with other letters than A-Z, a-z, 0-9, '_', '.', ':' is "
           "quoted");
    }
    ++at_;
    return append_use({reduction, field});
  }

  Expression& out_;
  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

Expression::Expression(std::string_view text, Scope scope) : text_(text), scope_(scope) {
  ExpressionParser(*this).parse();
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
