#include <iostream>

#include "compare/run.h"

int main(int argc, char** argv) {
  return insitu::compare::run(std::vector<std::string>(argv + 1, argv + argc), std::cout,
                              std::cerr);
}
