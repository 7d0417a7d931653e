# What every target of ours shares: the standard, the warnings, exact arithmetic, sanitizers.
#
#   isofront_library(core SOURCES src/A.cpp ... PUBLIC deps... PRIVATE deps...)
#       makes the library isofront_core with the alias isofront::core; public headers lie in include/.
#   isofront_target(name)   gives the settings to any other target.
#   isofront_test(name LABELS unit SOURCES A.cpp ... LINK isofront::core ...)

set(ISOFRONT_SANITIZE "" CACHE STRING "address;undefined or thread")

# For sources that are inlined so deeply that the full set costs a minute or more to compile.
set(ISOFRONT_LIGHT_SANITIZING -fno-sanitize=undefined)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND "address" IN_LIST ISOFRONT_SANITIZE)
  list(APPEND ISOFRONT_LIGHT_SANITIZING -fno-sanitize-address-use-after-scope)
endif()

function(isofront_target target)
  target_compile_features(${target} PUBLIC cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
  # Borders of cells agree to the last bit only if the same formula gives the same bits wherever it
  # is inlined: no contraction to FMA, ever.
  target_compile_options(
    ${target}
    PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion -Wdouble-promotion
            -Wnon-virtual-dtor -Woverloaded-virtual -ffp-contract=off)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Where GCC 12.2 vectorises straight-line code it drops the rounding of two neighbouring
    # double -> float -> double conversions, as in glm::dvec3(glm::vec3(p)). Loops are right.
    target_compile_options(${target} PRIVATE -fno-tree-slp-vectorize)
    # It sees overlapping copies in `"text" + std::string()` that are not there (its bug 105651).
    if(CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
      # clang-tidy, which reads the same command lines, must not trip over the name.
      target_compile_options(${target} PRIVATE -Wno-restrict -Wno-unknown-warning-option)
    endif()
  endif()
  target_compile_definitions(
    ${target} PUBLIC GLM_FORCE_XYZW_ONLY GLM_FORCE_EXPLICIT_CTOR GLM_FORCE_DEPTH_ZERO_TO_ONE
                     GLM_FORCE_SIZE_T_LENGTH)
  if(ISOFRONT_SANITIZE)
    list(JOIN ISOFRONT_SANITIZE "," sanitizers)
    # What the sanitizers weave in confuses the compiler's own watch over values that are not set
    # (GCC's manual says so of -fsanitize); the other builds keep it.
    target_compile_options(${target} PRIVATE -fsanitize=${sanitizers} -fno-omit-frame-pointer
                                             -Wno-maybe-uninitialized)
    target_link_options(${target} PUBLIC -fsanitize=${sanitizers})
  endif()
endfunction()

function(isofront_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;PUBLIC;PRIVATE")
  add_library(isofront_${name} STATIC ${arg_SOURCES})
  add_library(isofront::${name} ALIAS isofront_${name})
  target_include_directories(
    isofront_${name} PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    PRIVATE ${CMAKE_CURRENT_SOURCE_DIR}/include ${CMAKE_CURRENT_SOURCE_DIR}/src)
  target_link_libraries(isofront_${name} PUBLIC ${arg_PUBLIC} PRIVATE ${arg_PRIVATE})
  isofront_target(isofront_${name})
endfunction()

function(isofront_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINK;LABELS;ENVIRONMENT")
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE ${arg_LINK} GTest::gtest_main)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  isofront_target(${name})
  if("thread" IN_LIST ISOFRONT_SANITIZE)
    # The standard library has a fence, which the thread sanitizer doesn't follow.
    target_compile_options(${name} PRIVATE -Wno-tsan)
  endif()
  gtest_discover_tests(
    ${name}
    DISCOVERY_MODE PRE_TEST
    PROPERTIES LABELS "${arg_LABELS}" ENVIRONMENT "${arg_ENVIRONMENT}" TIMEOUT 600)
endfunction()
