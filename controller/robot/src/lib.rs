//! The run loop of one robot: mailboxes, tick, codecs, links, shutdown.
