#include "scene/expression/expression_text.h"

#include <charconv>
#include <cmath>

#include "scene/expression/expression.h"
#include "scene/parse/problems.h"

namespace insitu::scene {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_name(char c) {
  return is_letter(c) || is_digit(c) || c == '.' || c == ':';
}

} // namespace

void ExpressionText::fail(const std::string& message, std::size_t place) const {
  throw ExpressionError(place + 1, message);
}

bool ExpressionText::is_letter_at(std::size_t place) const {
  return is_letter(byte_at(place));
}

bool ExpressionText::is_number() const {
  return is_digit(next()) || next() == '.';
}

bool ExpressionText::is_comparison() const {
  const char c = next();
  return c == '<' || c == '>' || c == '=' || (c == '!' && text_.substr(at_, 2) == "!=");
}

std::string_view ExpressionText::name_at(std::size_t place) const {
  std::size_t end = place;
  while (is_name(byte_at(end)))
    ++end;
  return text_.substr(place, end - place);
}

std::string ExpressionText::here() const {
  if (is_at_end())
    return "end of the condition";
  if (is_name(next()))
    return quote(name_at(at_));
  std::size_t end = at_ + 1;
  while (end < text_.size() && continues_letter(text_[end]))
    ++end;
  return quote(text_.substr(at_, end - at_));
}

std::size_t ExpressionText::start() {
  while (at_ < text_.size() &&
         (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r'))
    ++at_;
  return at_;
}

bool ExpressionText::accept(std::string_view symbol) {
  start();
  if (text_.substr(at_, symbol.size()) != symbol)
    return false;
  at_ += symbol.size();
  return true;
}

bool ExpressionText::accept_word(std::string_view word) {
  start();
  if (text_.substr(at_, word.size()) != word || is_name(byte_at(at_ + word.size())))
    return false;
  at_ += word.size();
  return true;
}

void ExpressionText::expect(std::string_view symbol, const std::string& after) {
  if (!accept(symbol))
    fail("'" + std::string(symbol) + "' expected " + after + ", " + here() + " found");
}

double ExpressionText::number() {
  const char* begin = text_.data() + at_;
  double value = 0;
  const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
  if (error != std::errc() || !std::isfinite(value))
    fail(here() + " is not a finite number");
  const std::size_t begin_at = at_;
  at_ += static_cast<std::size_t>(end - begin);
  if (is_name(next())) {
    at_ = begin_at;
    fail(here() + " is not a number");
  }
  return value;
}

std::string ExpressionText::field_name(const std::string& in) {
  std::string field;
  const std::size_t first = at_;
  if (is_quote_at(at_)) {
    const std::size_t close = text_.find(text_[at_], at_ + 1);
    if (close == std::string_view::npos)
      fail("the quotation mark is not closed");
    field = text_.substr(at_ + 1, close - at_ - 1);
    at_ = close + 1;
  } else {
    field = name_at(at_);
    at_ += field.size();
  }
  if (field.empty())
    fail("the name of a field expected" + in + ", " + here() + " found", first);
  return field;
}

} // namespace insitu::scene
