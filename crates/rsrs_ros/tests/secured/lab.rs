//! A lab with a keystore.

use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::{Arc, Mutex};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rsrs_keystore::create::{KeystoreRequest, create};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::Qos;
use rsrs_ros::interfaces::LOOPBACK;
use rsrs_ros::security::{Enclave, Member, SecurityError, SecurityRequest, Strategy};
use rsrs_ros::session::{ReceivedRaw, Session, SessionError, SessionOptions, Subscription};
use tempfile::TempDir;

/// That of all sessions in these tests.
pub const DOMAIN: u16 = 42;
/// What the process publishes that is killed.
pub const DETECTIONS: &str = "/robot_1/detection";
/// The variable that names the keystore to a process that a lab starts.
const KEYSTORE: &str = "RSRS_TEST_KEYSTORE";

pub struct Lab {
    keystore: TempDir,
}

impl Lab {
    /// With a keystore for two robots.
    pub fn new() -> Self {
        let keystore = tempfile::tempdir().expect("a temporary folder");
        let robots = ["robot_1", "robot_2"].map(str::to_owned);
        create(&KeystoreRequest {
            folder: keystore.path(),
            robots: &robots,
            domain_id: Some(DOMAIN),
            now: SystemTime::now().duration_since(UNIX_EPOCH).expect("it is after 1970"),
            validity: Some(Duration::from_secs(24 * 3600)),
            readmitted: &[],
        })
        .expect("the lab works");
        Self { keystore }
    }

    /// The folder of an enclave.
    pub fn path(&self, enclave: &str) -> PathBuf {
        self.keystore.path().join("enclaves").join(enclave.trim_start_matches('/'))
    }

    pub fn enclave(&self, name: &str, domain_id: u16) -> Result<Option<Enclave>, SecurityError> {
        enclave_in(self.keystore.path(), name, domain_id)
    }

    pub fn open(&self, enclave: &str) -> Result<Session, SessionError> {
        open_in(self.keystore.path(), enclave)
    }

    /// A session in an enclave that is well.
    pub fn member(&self, enclave: &str) -> Session {
        self.open(enclave).expect("the enclave is well")
    }

    /// Signs the governance with the openssl program, after a change of its text.
    pub fn sign_governance_with_openssl(&self, change: impl Fn(&str) -> String) {
        self.sign_into(&self.keystore.path().join("enclaves"), change);
    }

    /// A copy of an enclave, with a governance of its own.
    pub fn copied(&self, enclave: &str, change: impl Fn(&str) -> String) -> TempDir {
        let copy = tempfile::tempdir().expect("a temporary folder");
        for file in std::fs::read_dir(self.path(enclave)).expect("the enclave is there") {
            let file = file.expect("the enclave is there");
            std::fs::copy(file.path(), copy.path().join(file.file_name())).expect("writable");
        }
        self.sign_into(copy.path(), change);
        copy
    }

    fn sign_into(&self, into: &Path, change: impl Fn(&str) -> String) {
        let folder = self.keystore.path();
        let text = std::fs::read_to_string(folder.join("enclaves/governance.xml"));
        let changed = folder.join("changed.xml");
        std::fs::write(&changed, change(&text.expect("it is a text"))).expect("writable");
        let signed = Command::new("openssl")
            .args(["smime", "-sign", "-text", "-in"])
            .arg(changed)
            .arg("-signer")
            .arg(folder.join("public/permissions_ca.cert.pem"))
            .arg("-inkey")
            .arg(folder.join("private/permissions_ca.key.pem"))
            .arg("-out")
            .arg(into.join("governance.p7s"))
            .status();
        assert!(signed.expect("openssl is installed").success());
    }

    /// Starts a test in a process of its own, which acts as `/robot_1` by [`if_started`].
    pub fn start(&self, test: &str) -> Child {
        Command::new(std::env::current_exe().expect("a running test has an executable"))
            .args(["--exact", test, "--nocapture"])
            .env(KEYSTORE, self.keystore.path())
            .spawn()
            .expect("the lab works")
    }
}

fn enclave_in(
    keystore: &Path,
    name: &str,
    domain_id: u16,
) -> Result<Option<Enclave>, SecurityError> {
    let request = SecurityRequest {
        keystore: keystore.to_owned(),
        strategy: Strategy::Enforce,
        enclave: Some(name.to_owned()),
    };
    let now = SystemTime::now().duration_since(UNIX_EPOCH).expect("it is after 1970");
    request.enclave(Member::Runner, domain_id, now)
}

fn open_in(keystore: &Path, enclave: &str) -> Result<Session, SessionError> {
    let enclave = enclave_in(keystore, enclave, DOMAIN).expect("the enclave looks well");
    assert!(enclave.is_some(), "the strategy is to enforce");
    join(enclave)
}

/// A session in an enclave that was looked at.
pub fn join(enclave: Option<Enclave>) -> Result<Session, SessionError> {
    Session::open(&SessionOptions { domain_id: DOMAIN, interfaces: vec![LOOPBACK], enclave })
}

/// Acts as `/robot_1`, if this process was started for that.
pub fn if_started(act: impl AsyncFnOnce(Session)) {
    let Some(keystore) = std::env::var_os(KEYSTORE) else { return };
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().expect("the lab works");
    runtime.block_on(async {
        act(open_in(Path::new(&keystore), "/robot_1").expect("the lab works")).await;
    });
}

/// Publishes for ever, if this process was started for that.
pub fn publish_if_started() {
    if_started(async |session| {
        let node = session.node("/robot_1", "robot").expect("the lab works");
        let publisher = session
            .publish_on::<Bool>(&node, DETECTIONS, Qos::reliable(100))
            .expect("the lab works");
        loop {
            publisher.publish(Bool { data: true }).await.expect("the lab works");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    });
}

/// What came on a topic so far.
pub struct Inbox {
    samples: Arc<Mutex<Vec<Vec<u8>>>>,
    _subscription: Subscription,
}

impl Inbox {
    pub fn lock(&self) -> std::sync::LockResult<std::sync::MutexGuard<'_, Vec<Vec<u8>>>> {
        self.samples.lock()
    }
}

/// Collects what comes on a topic.
pub fn subscribe(session: &Session, topic: &str, type_name: &str, qos: Qos) -> Inbox {
    let samples = Arc::new(Mutex::new(Vec::new()));
    let collected = Arc::clone(&samples);
    let deliver = move |sample: ReceivedRaw| {
        collected.lock().expect("nobody panicked with it").push(sample.message);
    };
    let subscription =
        session.subscribe_raw(topic, type_name, qos, deliver).expect("the lab works");
    Inbox { samples, _subscription: subscription }
}

/// Leaves the network, one after the other.
pub async fn close(sessions: impl IntoIterator<Item = Session>) {
    for session in sessions {
        session.close().await;
    }
}
