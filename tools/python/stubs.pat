# What is left out of the stubs. These two name the nearest of a misspelt setting: a type checker would believe that there is
# any setting.
_parloc\..*\.__(get|set)attr__$:

# None, where a checker expects a method.
_parloc\..*\.__hash__$:
