#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace insitu::scene {

/// Whether a byte goes on with a letter of UTF-8 that began before it.
inline bool continues_letter(char c) {
  return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
}

/// Reads the text of an expression from its start to its end: symbols, words, numbers and names of
/// fields. The grammar is ExpressionParser's.
class ExpressionText {
public:
  explicit ExpressionText(std::string_view text) : text_(text) {}

  std::size_t size() const { return text_.size(); }
  bool is_at_end() const { return at_ >= text_.size(); }
  /// The byte at the current position, 0 at the end.
  char next() const { return byte_at(at_); }
  /// The byte at a place, 0 beyond the end.
  char byte_at(std::size_t place) const { return place < text_.size() ? text_[place] : '\0'; }
  bool is_letter_at(std::size_t place) const;
  bool is_quote_at(std::size_t place) const {
    return byte_at(place) == '"' || byte_at(place) == '\'';
  }
  bool is_number() const;
  bool is_comparison() const;
  /// What could be the name of a field or of a function at a place.
  std::string_view name_at(std::size_t place) const;
  /// What stands at the current position, for messages.
  std::string here() const;

  /// Skips blanks; returns where the next operand begins, for messages about it.
  std::size_t start();
  bool accept(std::string_view symbol);
  /// Accepts a whole word: "or" is not the beginning of "order".
  bool accept_word(std::string_view word);
  /// Throws unless the symbol follows.
  void expect(std::string_view symbol, const std::string& after);
  /// Reads a finite number.
  double number();
  /// Reads a name as it is or within quotes; `in` is where, for messages.
  std::string field_name(const std::string& in);

  /// Throws ExpressionError at the current position, or at another place.
  [[noreturn]] void fail(const std::string& message) const { fail(message, at_); }
  [[noreturn]] void fail(const std::string& message, std::size_t place) const;

private:
  std::string_view text_;
  std::size_t at_ = 0;
};

} // namespace insitu::scene
