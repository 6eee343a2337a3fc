#pragma once

#include <gtest/gtest.h>

#include <string>

#include "firn/math.h"

namespace firn::test {

// The message of the error that `act` throws; empty if it throws none.
template <class Error = InputError, class Action>
std::string error_if_any(const Action& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// The message of the error that `act` throws. The test fails if it throws none.
template <class Error = InputError, class Action>
std::string error_of(const Action& act) {
  std::string message = error_if_any<Error>(act);
  EXPECT_FALSE(message.empty()) << "no error was thrown";
  return message;
}

}  // namespace firn::test
