# A code block of a document shows exactly the lines of a program between two marks.
#
#   cmake -D DOCUMENT=README.md -D NAME=embedding -D SOURCE=main.cpp -P snippet.cmake
#
# In the document the block follows the line "<!-- snippet: NAME -->"; in the program the lines lie
# between "// [snippet]" and "// [/snippet]". Their common indentation of four is not compared, nor
# is a closing brace that ends the block: what the program does after the marks is its own.

function(fail message)
  message(FATAL_ERROR "${DOCUMENT} and ${SOURCE}: ${message}")
endfunction()

# The text between two marks, or nothing.
function(between text begin end result)
  string(FIND "${text}" "${begin}" from)
  if(from EQUAL -1)
    fail("'${begin}' is missing")
  endif()
  string(LENGTH "${begin}" length)
  math(EXPR from "${from} + ${length}")
  string(SUBSTRING "${text}" ${from} -1 text)
  string(FIND "${text}" "${end}" to)
  if(to EQUAL -1)
    fail("'${end}' is missing after '${begin}'")
  endif()
  string(SUBSTRING "${text}" 0 ${to} text)
  set(${result} "${text}" PARENT_SCOPE)
endfunction()

file(READ ${DOCUMENT} document)
file(READ ${SOURCE} source)
between("${document}" "<!-- snippet: ${NAME} -->\n```cpp\n" "```" shown)
between("${source}" "// [snippet]\n" "// [/snippet]" marked)

string(REGEX REPLACE "\n +$" "\n" marked "${marked}")
string(REGEX REPLACE "^    " "" marked "${marked}")
string(REPLACE "\n    " "\n" marked "${marked}")
string(REGEX REPLACE "\n}\n$" "\n" shown "${shown}")
if(NOT shown STREQUAL marked)
  fail("they differ.\n--- shown\n${shown}--- marked\n${marked}")
endif()
if(marked STREQUAL "")
  fail("there is nothing between the marks")
endif()
