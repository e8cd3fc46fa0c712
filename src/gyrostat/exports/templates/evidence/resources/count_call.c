@copies@
int __real_@name@(@parameters@);
int __wrap_@name@(@parameters@);
static void call_@name@(void) { status = __real_@name@(@values@); }
static Count count_@name@ = {"@name@", call_@name@, 0u, 0u};
int __wrap_@name@(@parameters@)
{
@stores@
    count(&count_@name@);
    return status;
}
